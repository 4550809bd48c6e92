"""Calibrating from the command line: the depth job, the live coach, simulated scenes."""
