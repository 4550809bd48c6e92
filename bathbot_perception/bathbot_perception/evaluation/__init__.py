"""How good a detector is, and the model card that says so."""
