"""Gathers calibration views from a running camera: still moments before the board, each pose once."""

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.calibration.coverage import ViewPose, coverage_of, gain_words, is_new, pose_of
from bathbot_depthcorr.calibration.wall_guards import LEAST_WALL
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros.camera_health import CameraHealth
from bathbot_depthcorr.views.bag_views import Recording
from bathbot_depthcorr.views.chessboard import (
    LEAST_CORNER_NOISE,
    BoardNotFoundError,
    Chessboard,
    board_plane,
    board_pose,
    find_corners,
)
from bathbot_depthcorr.views.colour_reference import BoardView
from bathbot_depthcorr.views.sharpness import MOST_EDGE_WIDTH, edge_width
from bathbot_depthcorr.views.still_watch import MOST_FRAMES, MeanDepth, StillSpan, StillWatch, mean_depth
from bathbot_depthcorr.views.views import CalibrationView

HOLD = 0.4  # [s] without motion, and
LEAST_PICTURES = 3  # pictures of each kind, before a pose is taken


class StillMoment(NamedTuple):
    """A still span in colour, and the mean of its depth."""

    span: StillSpan
    depth: MeanDepth


class Look(NamedTuple):
    """What a picture showed: where the camera is, if the board was found, and a few words.

    Attributes:
        pose: None without the board.
        taken: Whether it became a view.
        words: What happened.
    """

    pose: ViewPose | None
    taken: bool
    words: str


class LiveViews:
    """Takes colour and depth as they come; gives still moments to look at; keeps what serves."""

    def __init__(self, board: Chessboard, colour_camera: Pinhole, unit: CameraUnit) -> None:
        """Begin without views.

        Args:
            board: The chessboard on the wall.
            colour_camera: As in camera_info.
            unit: The same of the depth stream.
        """
        self._board, self._colour_camera, self._unit = board, colour_camera, unit
        self._watch = StillWatch()
        self._newest: NDArray[np.uint8] | None = None
        self._depths: list[tuple[float, NDArray[np.float32]]] = []
        self._used = -np.inf  # start of the last span that was looked at
        self.boards: list[BoardView] = []
        self.poses: list[ViewPose] = []

    def push_colour(self, stamp: float, colour: NDArray[np.uint8]) -> None:
        """Take a picture, RGB, shape (H, W, 3), of a time [s]."""
        self._watch.push(stamp, colour)
        self._newest = colour
        self._depths = [entry for entry in self._depths if entry[0] >= self._watch.begun]

    def push_depth(self, stamp: float, depth: NDArray[np.float32]) -> None:
        """Take a depth image [m], shape (H, W), of a time [s]."""
        self._depths = [*self._depths[1 - MOST_FRAMES :], (stamp, depth)]

    def still_moment(self) -> StillMoment | None:
        """The present moment, once per pose, as soon as the camera has stood long enough."""
        lasted, pictures = self._watch.stood
        if lasted < HOLD or pictures < LEAST_PICTURES or self._watch.begun <= self._used:
            return None
        span = self._watch.span()
        depths = [depth for stamp, depth in self._depths if span.start <= stamp <= span.end]
        if len(depths) < LEAST_PICTURES:
            return None
        self._used = span.start
        return StillMoment(span, mean_depth(depths))

    def take(self, moment: StillMoment) -> Look:
        """Look at a still moment, and keep it as a view if it serves."""
        grey = moment.span.grey
        try:
            corners = find_corners(grey, self._board)
            view = self._view(corners, moment.depth)
        except BoardNotFoundError as error:
            return Look(None, False, str(error))
        pose = pose_of(view, self._unit)
        refusal = self._refusal(edge_width(grey, corners, self._board), view, pose)
        if refusal:
            return Look(pose, False, refusal)
        gain = gain_words(coverage_of(self.poses).gain(pose))
        self.boards.append(BoardView(corners, *moment.depth))
        self.poses.append(pose)
        return Look(pose, True, f"view {len(self.poses)}: {gain}")

    def glance(self) -> ViewPose | None:
        """Where the camera is now, moving or not; None without the board."""
        if self._newest is None or not self._depths:
            return None
        try:
            corners = find_corners(cv2.cvtColor(self._newest, cv2.COLOR_RGB2GRAY), self._board)
            view = self._view(corners, MeanDepth(self._depths[-1][1], 1, 0.0))
        except BoardNotFoundError:
            return None
        return pose_of(view, self._unit)

    def recording(self, health: CameraHealth) -> Recording:
        """What was gathered, as if it had been recorded, from a camera whose health is known by now."""
        unit = replace(self._unit, serial=health.serial, temperature=health.temperature)
        return Recording(self.boards, self._colour_camera, unit, [])

    def _view(self, corners: NDArray[np.float64], depth: MeanDepth) -> CalibrationView:
        pose, _ = board_pose(corners, self._board, self._colour_camera)
        plane, covariance = board_plane(pose, self._board, self._colour_camera, LEAST_CORNER_NOISE)
        return CalibrationView(depth.depth, plane, covariance, depth.frames, depth.noise)

    def _refusal(self, width: float, view: CalibrationView, pose: ViewPose) -> str:
        """Why a view does not serve; empty if it does."""
        if width > MOST_EDGE_WIDTH:
            return f"blurred: edges {width:.1f} px wide, sharp are {MOST_EDGE_WIDTH:.0f}; more light helps"
        if (share := float(np.isfinite(view.depth).mean())) < LEAST_WALL:
            return f"depth shows the wall on {share:.0%} of the picture only, {LEAST_WALL:.0%} are needed"
        return "" if is_new(pose, self.poses) else "this pose is there already; move on"
