"""The correction at work on a running camera."""
