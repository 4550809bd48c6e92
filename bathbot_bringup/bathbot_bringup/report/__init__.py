"""What a run was like, against the simulated truth."""
