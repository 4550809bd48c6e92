"""How good the whole is, over many seeds."""
