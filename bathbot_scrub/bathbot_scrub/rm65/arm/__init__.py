"""The arm itself: kinematics, limits and shape."""
