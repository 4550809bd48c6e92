"""The arm in motion: the control loop and what it commands."""
