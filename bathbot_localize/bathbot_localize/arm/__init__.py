"""The arm in the picture, and room for it over the skin."""
