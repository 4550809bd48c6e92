"""Depth corrections and how each is fitted, Eqs. (3)-(4)."""
