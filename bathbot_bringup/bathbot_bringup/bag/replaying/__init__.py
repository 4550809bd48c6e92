"""Publishing a bag again, and the pipeline over it."""
