"""The frame of every node."""
