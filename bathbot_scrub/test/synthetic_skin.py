"""Skin for tests: a cylinder or a plane in front of the base, as a depth camera at the origin sees it."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from, transform_points
from scipy.spatial.transform import Rotation

DISTANCE = 0.7  # of the nearest skin from the camera [m]


def rays(height=160, width=220, focal=300.0):
    """Directions (1, y, z) of pixels that look along +x, shape (H, W, 3)."""
    u, v = np.meshgrid(np.arange(width) - width / 2 + 0.5, np.arange(height) - height / 2 + 0.5)
    return np.stack([np.ones_like(u), -u / focal, -v / focal], axis=-1)


def cylinder(radius=0.15, noise=0.0, out=0.0, seed=0):
    """Upright cylinder whose front is `DISTANCE - out` away, shape (H, W, 3) [m]; NaN beside it."""
    along, middle = rays(), DISTANCE + radius
    a = along[..., 0] ** 2 + along[..., 1] ** 2
    b, c = -2.0 * middle * along[..., 0], middle**2 - (radius + out) ** 2
    inside = b * b - 4.0 * a * c
    with np.errstate(invalid="ignore"):
        range_ = (-b - np.sqrt(np.where(inside > 0.0, inside, np.nan))) / (2.0 * a)
    return along * (range_ + noise * np.random.default_rng(seed).normal(size=range_.shape))[..., None]


def plane(noise=0.0, out=0.0, seed=0):
    """Wall across x, `DISTANCE - out` away, shape (H, W, 3) [m]."""
    along = rays()
    range_ = DISTANCE - out + noise * np.random.default_rng(seed).normal(size=along.shape[:2])
    return along * range_[..., None]


def target(travel=(0.0, 0.0, 1.0), point=(DISTANCE, 0.0, 0.0)):
    """Contact target on the nearest skin: z = +x of the base into the skin, y = `travel`."""
    y, z = np.asarray(travel, dtype=float), np.array([1.0, 0.0, 0.0])
    return transform_from(np.stack([np.cross(y, z), y, z], axis=-1), point)


def moved(transform, surface):
    """An organised surface, NaN kept, moved by a transform (4, 4)."""
    return transform_points(transform, surface)


def somewhere(seed):
    """A rigid transform far from the identity, shape (4, 4)."""
    rng = np.random.default_rng(seed)
    return transform_from(Rotation.random(random_state=rng).as_matrix(), rng.uniform(-1.0, 1.0, 3))


def cylinder_normals(points, radius=0.15):
    """Outward normals of `cylinder` at points (N, 3), shape (N, 3)."""
    across = points - np.array([DISTANCE + radius, 0.0, 0.0])
    across[:, 2] = 0.0
    return across / np.linalg.norm(across, axis=1, keepdims=True)
