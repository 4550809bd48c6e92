"""Scrub paths on skin: scan lines, B-splines, normals, segments and tool poses, Eqs. (6)-(18)."""
