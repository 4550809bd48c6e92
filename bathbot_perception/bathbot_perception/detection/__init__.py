"""Regions of bare skin in one picture."""
