"""Where the camera stands: hand-eye calibration."""
