"""Scrub paths on skin, and the arm that follows them (paper, section 2.2)."""
