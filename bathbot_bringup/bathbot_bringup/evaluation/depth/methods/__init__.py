"""Depth corrections that others published."""
