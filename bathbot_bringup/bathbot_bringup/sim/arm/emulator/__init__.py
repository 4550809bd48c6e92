"""The controller's network side."""
