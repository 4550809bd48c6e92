"""What can fail in the simulated arm, where it acts, and when."""
