"""The force sensor: limits, filter, the tool's weight, zeroing."""
