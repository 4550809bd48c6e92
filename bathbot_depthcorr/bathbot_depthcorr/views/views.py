"""What a calibration learns from: a flat wall in depth, and its true plane from the colour camera.

Blocks of pixels sum a view up; `Steps` is who hears how far the reading of views and the fit are.
"""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationView:
    """One pose of the camera before the wall.

    Attributes:
        depth: Raw depth [m], mean of the still frames, shape (H, W), NaN = none.
        plane: The wall in the colour frame, from the chessboard.
        covariance: Of the plane's inverse form m (m.x = 1) [1/m^2], shape (3, 3); zero if it is exact.
        frames: How many frames `depth` is the mean of.
        temporal_noise: Standard deviation of inverse depth between frames [1/m].
    """

    depth: NDArray[np.float32]
    plane: Plane
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    frames: int = 1
    temporal_noise: float = 0.0

    @property
    def distance(self) -> float:
        """Distance of the wall along the colour camera's axis [m]."""
        return float(self.plane.depth_along((0.0, 0.0, 1.0)))

    @property
    def tilt(self) -> float:
        """Angle between the wall's normal and the colour camera's axis [rad]."""
        return float(np.arccos(min(1.0, abs(self.plane.normal[2]))))


def block_size(camera: Pinhole) -> int:
    """Edge of the blocks [px]: about a hundred across the image."""
    return 8 if camera.width <= 900 else 12 if camera.width < 1200 else 16


def block_centres(camera: Pinhole) -> tuple[Array, Array]:
    """Columns u and rows v [px] of the centres of the blocks."""
    size = block_size(camera)
    centre = 0.5 * (size - 1)
    return centre + size * np.arange(camera.width // size), centre + size * np.arange(camera.height // size)


def block_means(values: NDArray, valid: NDArray, size: int) -> Array:
    """Means of values, shape (H, W), over the valid pixels of each block; NaN where less than half are."""
    rows, columns = values.shape[0] // size, values.shape[1] // size
    shape = (rows, size, columns, size)
    inside = (slice(rows * size), slice(columns * size))
    count = valid[inside].reshape(shape).sum(axis=(1, 3))
    total = np.where(valid, values, 0.0)[inside].reshape(shape).sum(axis=(1, 3))
    return np.where(count >= 0.5 * size * size, total / np.maximum(count, 1), np.nan)


def true_disparity(view: CalibrationView, unit: CameraUnit, directions: Array) -> Array:
    """Disparity [px], shape (...), that the wall should have along depth rays, shape (..., 3)."""
    m = view.plane.inverse_form
    transform = unit.T_colour_depth
    rotated = transform[:3, :3].T @ m
    return unit.focal_baseline * (directions @ rotated) / (1.0 - m @ transform[:3, 3])


def true_depth(view: CalibrationView, unit: CameraUnit) -> Array:
    """Depth [m], shape (H, W), that the wall should have in the depth image."""
    camera = unit.depth_camera
    disparity = true_disparity(view, unit, camera.directions(camera.pixel_grid()))
    return np.where(disparity > 0.0, unit.focal_baseline / np.where(disparity > 0.0, disparity, 1.0), np.nan)


def nearest_first(views: Sequence[CalibrationView]) -> list[CalibrationView]:
    """Views ordered by distance, near to far."""
    return sorted(views, key=lambda view: view.distance)


class Steps:
    """Hears how a calibration goes; this one hands each line to a function and shows no bars."""

    def __init__(self, tell: Callable[[str], None] = lambda _: None) -> None:
        """Remember whom to tell.

        Args:
            tell: Called with one line at a time.
        """
        self._tell = tell

    def stage(self, name: str, about: str) -> AbstractContextManager[None]:
        """Wrap a stage of the job: its short name and what it does."""
        self._tell(about)
        return nullcontext()

    def note(self, text: str) -> None:
        """Take one line about the running stage."""
        self._tell(text)

    def progress(self, fraction: float, detail: str) -> None:
        """Hear how much of the running stage is done, 0..1, and of what."""
