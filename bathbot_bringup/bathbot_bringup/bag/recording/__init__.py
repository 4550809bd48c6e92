"""Recording what a privacy profile allows."""
