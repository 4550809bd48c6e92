"""Simple surfaces with exact answers, for tests and for an emulator without a person."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class NoSurface:
    """Empty space."""

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Nothing is hit."""
        return np.full(len(origins), np.inf), np.zeros((len(origins), 3)), ""


@dataclass(frozen=True, slots=True)
class PlaneSurface:
    """A plane n.x = d whose offset may move: d + shift(t) [m]."""

    normal: tuple[float, float, float]
    offset: float
    part: str = "Trunk_skin"
    shift: Callable[[float], float] = lambda t: 0.0

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Distances [m], shape (N,), normals (N, 3) and the part."""
        normal = np.asarray(self.normal)
        towards = directions @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            distances = (self.offset + self.shift(t) - origins @ normal) / towards
        distances = np.where((towards < 0.0) & (distances >= 0.0), distances, np.inf)
        return distances, np.tile(normal, (len(origins), 1)), self.part if np.isfinite(distances[0]) else ""


@dataclass(frozen=True, slots=True)
class SphereSurface:
    """A ball."""

    centre: tuple[float, float, float]
    radius: float
    part: str = "Trunk_skin"

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Distances [m], shape (N,), normals (N, 3) and the part."""
        away = origins - np.asarray(self.centre)
        along = np.sum(away * directions, -1)
        root = along**2 - np.sum(away**2, -1) + self.radius**2
        distances = np.where(root >= 0.0, -along - np.sqrt(np.maximum(root, 0.0)), np.inf)
        distances = np.where(distances >= 0.0, distances, np.inf)
        reached = np.where(np.isfinite(distances), distances, 0.0)
        normals = (away + reached[:, None] * directions) / self.radius
        return distances, normals, self.part if np.isfinite(distances[0]) else ""
