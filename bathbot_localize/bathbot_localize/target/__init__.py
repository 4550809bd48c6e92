"""From regions to contact targets in the base frame."""
