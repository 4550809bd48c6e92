"""The arm in the picture with its scrub head, and room for it over the skin."""
