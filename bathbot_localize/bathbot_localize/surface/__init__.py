"""Skin as a surface: registration, discs, normals, the workspace."""
