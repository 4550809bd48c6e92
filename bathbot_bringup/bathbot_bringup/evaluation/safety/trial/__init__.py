"""One trial of the fault matrix."""
