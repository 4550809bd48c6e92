"""What can fail in the simulated arm, and when."""
