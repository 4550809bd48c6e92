"""How good depth corrections are, measured on simulated cameras whose truth is known."""
