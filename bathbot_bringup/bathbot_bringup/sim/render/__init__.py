"""Pictures of the simulated bathroom."""
