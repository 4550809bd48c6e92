"""The force sensor: filter, the tool's weight, zeroing."""
