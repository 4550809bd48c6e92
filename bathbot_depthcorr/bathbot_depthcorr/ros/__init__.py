"""Messages and bags of a depth camera."""
