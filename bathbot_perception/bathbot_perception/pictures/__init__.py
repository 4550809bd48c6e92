"""Pictures and boxes on file."""
