"""Models for other machines."""
