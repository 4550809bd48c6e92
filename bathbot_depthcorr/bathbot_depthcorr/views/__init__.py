"""What a calibration learns from: views of a wall, from folders, bags and the live camera."""
