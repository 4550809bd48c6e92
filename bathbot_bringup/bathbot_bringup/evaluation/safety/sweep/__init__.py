"""Sweeps in virtual time: how hard a body is met when it comes, leans in, or lies where a path does not."""
