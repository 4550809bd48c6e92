"""Depth correction: the per-pixel and the global stage (paper, section 2.1.2)."""
