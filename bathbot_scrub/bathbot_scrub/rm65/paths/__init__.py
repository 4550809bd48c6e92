"""Where the arm may go: joint paths, free space, retracting, itself, walls and body."""
