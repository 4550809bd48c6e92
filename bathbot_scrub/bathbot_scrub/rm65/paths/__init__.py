"""Where the arm may go: joint paths, free space, clearance from body and room."""
