"""One simulated D455 whose correction is to be judged: what it is calibrated on, and what it then sees.

The walls of the calibration are known as well as a real one's: from the corners of a chessboard, found to
0.08 px in a colour camera whose published numbers are a little off. No picture is drawn for that; the bags
of `bathbot simulate board` have real ones.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import cv2
import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_depthcorr.views.chessboard import Chessboard
from bathbot_depthcorr.views.colour_reference import BoardView, ColourReference, views_from_boards
from bathbot_depthcorr.views.views import CalibrationView
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.camera.calibration_scene import INNER_CORNERS, SQUARE, STEEPEST, board_views
from bathbot_bringup.sim.camera.d455 import D455, Air
from bathbot_bringup.sim.camera.d455_unit import BASELINE, Preset

Array = NDArray[np.float64]
Depth = NDArray[np.float32]

CORNER_NOISE = 0.08  # [px] rms
NEAREST_VIEW, FARTHEST_VIEW = 0.5, 2.0  # [m] of the calibration
CELSIUS = 30.0
_EDGE = 9  # [px] width of what is left out along the outline of a curved surface
_STEEPEST = np.cos(np.deg2rad(60.0))


@dataclass(frozen=True, slots=True)
class Recording:
    """One calibration's circumstances.

    Attributes:
        poses: Views of the board.
        frames: Depth frames averaged in each.
        steepest: Largest tilt of the board [rad].
        focal_error: Published focal length of the colour camera over the true one, minus 1, beyond what a
            usual unit has.
        square_error: Edge of the printed squares over the one that is told, minus 1.
        outliers: Share of depth pixels that a wrong match moved by 2 to 10 px.
    """

    poses: int = 24
    frames: int = 4
    steepest: float = STEEPEST
    focal_error: float = 0.0
    square_error: float = 0.0
    outliers: float = 0.0


class Surface(Protocol):
    """Anything rays can meet."""

    def depth_along(self, directions: ArrayLike) -> Array:
        """Depth [m] along rays (x/z, y/z, 1), shape (..., 3); NaN if they miss."""
        ...

    def transformed(self, transform: ArrayLike) -> "Surface":
        """The same surface in another frame."""
        ...


class SimulatedUnit:
    """A simulated camera, with and without its noise."""

    def __init__(self, seed: int, preset: Preset, width: int, height: int) -> None:
        """Make the unit.

        Args:
            seed: Of the unit, of its noise and of where it stands.
            preset: Size of its errors.
            width: Of the depth stream [px].
            height: Of the depth stream [px].
        """
        self.seed = seed
        self._sensor = D455(seed, preset, width, height)
        silent = replace(preset, frozen=0.0, temporal=0.0, subpixels=0, unit=0.0)
        self._silent = D455(seed, silent, width, height)
        published = self._sensor.unit
        self.factory = CameraUnit(
            published.published_depth, published.published_T_colour_depth, published.serial, CELSIUS, BASELINE
        )
        self._rays = published.depth.directions(published.depth.pixel_grid())
        self._published_rays = self.factory.depth_camera.directions(self.factory.depth_camera.pixel_grid())

    def calibration_views(
        self, recording: Recording = Recording()
    ) -> tuple[list[CalibrationView], ColourReference]:
        """Walls seen from many places, and what their chessboards say about the colour camera."""
        unit, board = self._sensor.unit, Chessboard(*INNER_CORNERS, SQUARE)
        printed = (board.corners - board.corners.mean(axis=0)) * (1.0 + recording.square_error)
        poses = board_views(
            unit.colour, recording.poses, self.seed, NEAREST_VIEW, FARTHEST_VIEW, recording.steepest
        )
        boards = []
        for number, T_board_colour in enumerate(poses):
            # Of its own for each, so that a change of one circumstance leaves the luck of the others.
            at_corners, rng = (np.random.default_rng([self.seed, part, number]) for part in (91, 94))
            T_colour_board = inverse(T_board_colour)
            corners = unit.colour.project(transform_points(T_colour_board, printed))
            corners = corners + at_corners.normal(0.0, CORNER_NOISE, corners.shape)
            normal = -T_colour_board[:3, 2]
            truth = self.truth(Plane(normal, float(normal @ T_colour_board[:3, 3])))
            frames = [self._frame(truth, rng, number, CELSIUS) for _ in range(recording.frames)]
            stack = 1.0 / np.stack([self._mismatched(frame, rng, recording.outliers) for frame in frames])
            noise = float(np.nanmedian(stack.std(axis=0, ddof=1))) if len(stack) > 1 else 0.0
            boards.append(
                BoardView(corners, (1.0 / stack.mean(axis=0)).astype(np.float32), len(stack), noise)
            )
        longer = 1.0 + recording.focal_error
        published = unit.published_colour
        published = replace(published, fx=published.fx * longer, fy=published.fy * longer)
        return views_from_boards(boards, board, published)

    @property
    def T_colour_depth(self) -> Array:
        """The true transform, shape (4, 4)."""
        return self._sensor.unit.T_colour_depth

    def truth(self, surface: Surface) -> Depth:
        """True depth [m], shape (H, W), of a surface given in the colour frame; NaN where there is none."""
        there = surface.transformed(inverse(self.T_colour_depth))
        return there.depth_along(self._rays).astype(np.float32)

    def clean(self, truth: Depth) -> Depth:
        """What the unit reports [m], shape (H, W), of true depth, without noise and rounding."""
        return self._silent.sense(truth, np.random.default_rng(0))

    def frame(
        self, truth: Depth, number: int, pose: int, celsius: float = CELSIUS, air: Air = Air()
    ) -> Depth:
        """One frame [m], shape (H, W), as it comes from the topic.

        Args:
            truth: True depth [m], shape (H, W).
            number: Of the frame; temporal noise follows from it.
            pose: Of the scene; frozen noise follows from it.
            celsius: Temperature of the unit.
            air: Water on skin, in the air and on the window.
        """
        rng = np.random.default_rng([self.seed, 92, pose, number])
        return self._frame(truth, rng, 1000 + pose, celsius, air)

    def expected(self, surface: Surface, T_colour_depth: Array, every: int = 1) -> Array:
        """Depth [m], shape (H, W), at which a user who trusts a transform would see a surface.

        Rays are those the camera publishes, so that errors of the intrinsics count as errors of depth.

        Args:
            surface: In the colour frame.
            T_colour_depth: That the user trusts.
            every: Give every so many rows and columns only.
        """
        rays = self._published_rays[::every, ::every]
        return surface.transformed(inverse(T_colour_depth)).depth_along(rays)

    def _mismatched(self, depth: Depth, rng: np.random.Generator, share: float) -> Depth:
        """Depth [m], some of whose pixels were matched elsewhere."""
        wrong = rng.random(depth.shape, dtype=np.float32) < share if share > 0.0 else np.zeros(1, bool)
        if not wrong.any():
            return depth
        off = rng.uniform(2.0, 10.0, depth.shape) * rng.choice((-1.0, 1.0), depth.shape)
        focal_baseline = self.factory.focal_baseline
        return np.where(wrong, focal_baseline / np.maximum(focal_baseline / depth + off, 1.0), depth)

    def _frame(
        self, truth: Depth, rng: np.random.Generator, pose: int, celsius: float, air: Air = Air()
    ) -> Depth:
        measured = self._sensor.measure(truth, rng, pose=pose, celsius=celsius, air=air)
        return np.where(measured > 0, measured * np.float32(1e-3), np.float32(np.nan))


def facing(depth: Array) -> NDArray[np.bool_]:
    """Pixels of a curved surface, shape (H, W), that neither lie near its outline nor are seen edge-on.

    Args:
        depth: Of the surface alone [m], NaN where rays miss it, shape (H, W).
    """
    seen = cv2.erode(np.isfinite(depth).astype(np.uint8), np.ones((_EDGE, _EDGE), np.uint8)) > 0
    along_v, along_u = np.gradient(np.log(np.where(np.isfinite(depth), depth, 1.0)))
    focal = 0.5 * depth.shape[1]  # of a lens as wide as the D455's
    return seen & (1.0 / np.sqrt(1.0 + focal**2 * (along_u**2 + along_v**2)) > _STEEPEST)
