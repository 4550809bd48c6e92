"""Recording and replaying bags under a privacy profile."""
