"""Points, planes and cameras, the geometry that every package shares."""
