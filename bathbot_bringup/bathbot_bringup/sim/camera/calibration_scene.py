"""Scenes for calibration: a chessboard on a wall seen from many places, a marker on the arm's flange.

A poster's frame has x right and y down as printed, z into the wall. The wall of the chessboard is the plane x
= 0 of the world (z up), which the camera looks at from positive x.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_from, transform_points
from bathbot_scrub.installed_arm import installed_arm
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.sim.camera.arm_mesh import ArmMesh
from bathbot_bringup.sim.camera.d455_unit import BASELINE, SEARCH, D455Unit
from bathbot_bringup.sim.camera.scene_camera import Frame
from bathbot_bringup.sim.render.light import Lamp, Lighting
from bathbot_bringup.sim.render.mesh import plain_mesh
from bathbot_bringup.sim.render.poster import Poster, draw_poster
from bathbot_bringup.sim.render.raster import project_vertices, rasterise
from bathbot_bringup.sim.render.render import Rendering, depth_of_room, developed, draw, picture_of_room
from bathbot_bringup.sim.render.room import Room, Tiles
from bathbot_bringup.sim.render.stage import Stage, lit_stage
from bathbot_bringup.sim.scene import true_camera_pose

Array = NDArray[np.float64]

INNER_CORNERS = (11, 8)  # of the chessboard
SQUARE = 0.05  # [m]
MARKER_ID = 582  # of cv2.aruco.DICT_ARUCO_ORIGINAL
MARKER_SIZE = 0.10  # [m]
PLATE_SIZE = 0.15  # [m] of the white plate the marker is printed on
BLACK, WHITE = 0.05, 0.85
NEAREST, FARTHEST = 0.45, 2.0  # [m] of a calibration's views
LEAST_SQUARE = 10.0  # [px] that a square must have for its corners to be found well
STEEPEST = np.deg2rad(28.0)  # tilt of the board
T_WORLD_BOARD = transform_from([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
T_WORLD_BOARD.setflags(write=False)


def chessboard() -> Poster:
    """The board of 11x8 inner corners, black at the top left, with a white margin of one square."""
    columns, rows = INNER_CORNERS[0] + 1, INNER_CORNERS[1] + 1
    odd = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    cells = np.full((rows + 2, columns + 2), WHITE, dtype=np.float32)
    cells[1:-1, 1:-1] = np.where(odd, WHITE, BLACK)
    return Poster(SQUARE * (columns + 2), SQUARE * (rows + 2), cells)


def marker() -> Poster:
    """The ArUco marker without margin."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_ARUCO_ORIGINAL)
    side = dictionary.markerSize + 2
    bits = cv2.aruco.generateImageMarker(dictionary, MARKER_ID, side)
    return Poster(MARKER_SIZE, MARKER_SIZE, np.where(bits > 127, WHITE, BLACK).astype(np.float32))


def board_corners() -> Array:
    """The outer inner corners of the board in its frame [m], shape (4, 3)."""
    x, y = (0.5 * SQUARE * (count - 1) for count in INNER_CORNERS)
    return np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])


def board_views(
    camera: Pinhole,
    count: int,
    seed: int,
    nearest: float = NEAREST,
    farthest: float = FARTHEST,
    steepest: float = STEEPEST,
) -> list[Array]:
    """Poses of the colour camera before the board: near and far, the board all over the picture.

    Three of four are tilted by more than half of the steepest tilt, the others by less.

    Args:
        camera: The colour camera; every inner corner is inside its picture.
        count: Number of poses.
        seed: For the random numbers.
        nearest: Distance of the board in the first pose [m].
        farthest: In the last; between them they are even in inverse distance.
        steepest: Largest tilt [rad].

    Returns:
        T_board_camera of each pose, shape (4, 4).
    """
    rng = np.random.default_rng([seed, 31])
    corners, views = board_corners(), []
    size = np.array([camera.width, camera.height])
    while len(views) < count:
        share = (len(views) + rng.uniform()) / count
        distance = 1.0 / (1.0 / nearest + share * (1.0 / farthest - 1.0 / nearest))
        # Tilted views tell the focal length of the colour camera, which is the ruler of it all.
        tilt = steepest * (rng.uniform(0.54, 1.0) if len(views) % 4 else rng.uniform(0.0, 0.54))
        towards = rng.uniform(0.0, 2.0 * np.pi)
        angles = [tilt * np.cos(towards), tilt * np.sin(towards), np.deg2rad(rng.uniform(-8.0, 8.0))]
        turn = Rotation.from_euler("xyz", angles).as_matrix()
        target = size * (
            0.5 + rng.uniform(-0.42, 0.42, 2)
        )  # [px] where the middle of the board shall be seen
        T_camera_board = transform_from(turn, camera.deproject(target, distance))
        seen = camera.project(transform_points(T_camera_board, corners))
        if np.isfinite(seen).all() and (seen > 14).all() and (seen < size - 14).all():
            views.append(inverse(T_camera_board))
    return views


def plain_room() -> tuple[Room, Lighting]:
    """A room with one flat wall at x = 0 and even light."""
    plaster = Tiles((10.0, 10.0), 0.0, (0.55, 0.54, 0.52), (0.5, 0.5, 0.5), 0.0, 0.0)
    room = Room((0.0, -3.0, -1.6), (5.0, 3.0, 1.6), plaster, plaster, (0.7, 0.7, 0.7))
    lamps = (Lamp(np.array([2.5, 1.0, 1.5]), np.array([1.2, 1.2, 1.2]), 0.3),)
    return room, Lighting(np.full(3, 0.45), np.full(3, 0.35), lamps)


class ChessboardView:
    """A camera that stands still before the board for a while, then somewhere else, to the last pose."""

    def __init__(self, unit: D455Unit, count: int, hold: float, seed: int) -> None:
        """Choose the poses.

        Args:
            unit: The camera.
            count: Number of poses.
            hold: How long each lasts [s].
            seed: Of the poses.
        """
        self._unit, self._hold = unit, hold
        # Nearer than this the depth camera is blind, and more so where a wall is tilted.
        nearest = max(NEAREST, 1.15 * unit.published_depth.fx * BASELINE / SEARCH)
        farthest = min(FARTHEST, unit.colour.fx * SQUARE / LEAST_SQUARE)
        self._views = board_views(unit.colour, count, seed, nearest, farthest)
        room, _ = plain_room()
        lighting = Lighting(np.full(3, 0.8), np.full(3, 0.6), ())  # no lamp: no shadows to look for
        speck = plain_mesh(
            [(4.0, 2.0, -1.5), (4.01, 2.0, -1.5), (4.0, 2.01, -1.5)], [(0, 1, 2)], (0.5, 0.5, 0.5)
        )
        self._stage = lit_stage(speck, room, lighting, np.random.default_rng(0))
        self._drawn = lru_cache(maxsize=1)(self._draw)

    def pose_number(self, t: float) -> int:
        """Which pose the camera is in at time t [s]."""
        return int(np.clip(t // self._hold, 0, len(self._views) - 1))

    def frame(self, t: float, joints: ArrayLike | None = None) -> Frame:
        """The view at time t [s]; the arm is not there."""
        return self._drawn(self.pose_number(t))

    def T_board_colour(self, number: int) -> Array:
        """True pose of the colour camera before the board."""
        return self._views[number]

    def _draw(self, number: int) -> Frame:
        T_world_colour = T_WORLD_BOARD @ self._views[number]
        T_world_depth = T_world_colour @ self._unit.T_colour_depth
        picture = picture_of_room(self._stage, self._unit.colour, T_world_colour)
        radiance, depth = picture.radiance.copy(), picture.depth.copy()
        draw_poster(
            chessboard(), T_WORLD_BOARD, self._unit.colour, T_world_colour, np.full(3, 0.95), radiance, depth
        )
        true = depth_of_room(self._stage.room, self._unit.depth, T_world_depth)
        return Frame(developed(cv2.GaussianBlur(radiance, (0, 0), 0.5)), true, number)


class MarkerTruth(NamedTuple):
    """What a hand-eye calibration is judged by: true poses of depth camera and marker, shape (4, 4) each."""

    T_base_camera: Array
    T_flange_marker: Array


class MarkerView:
    """The camera on its mast, and the arm with the marker's plate in place of the brush."""

    def __init__(self, unit: D455Unit, sensor_seed: int) -> None:
        """Draw what never moves.

        Args:
            unit: The camera.
            sensor_seed: Decides how the plate sits on the flange.
        """
        rng = np.random.default_rng([sensor_seed, 32])
        turn = Rotation.from_euler("xyz", [180.0, *rng.normal(0.0, 1.5, 2)], degrees=True).as_matrix()
        self.truth = MarkerTruth(
            true_camera_pose(), transform_from(turn, rng.normal((0.0, 0.0, 0.03), 0.004))
        )
        self._unit = unit
        self._T_base_colour = self.truth.T_base_camera @ inverse(unit.T_colour_depth)
        room, lighting = plain_room()
        room = Room((-1.2, -1.8, -0.75), (2.0, 1.8, 1.8), room.walls, room.floor, room.ceiling)
        self._arm = ArmMesh(head=False)
        home = self._arm.vertices(np.zeros(6))
        stage = lit_stage(
            plain_mesh(home, self._arm.mesh.faces, 0.5), room, lighting, np.random.default_rng(0)
        )
        self._arm_stage: Stage = stage.holding(self._arm.mesh)
        self._room = picture_of_room(stage, unit.colour, self._T_base_colour)
        self._room_depth = depth_of_room(room, unit.depth, self.truth.T_base_camera)

    def frame(self, t: float, joints: ArrayLike | None = None) -> Frame:
        """The view with the arm at joint angles [rad], shape (6,); None: no arm."""
        if joints is None:
            return Frame(self._room.colour, self._room_depth, 0)
        arm = self._arm.vertices(joints)
        picture = draw(self._arm_stage.moved(arm), self._unit.colour, self._T_base_colour, self._room)
        depth = rasterise(
            project_vertices(arm, self._unit.depth, self.truth.T_base_camera),
            self._arm.mesh.faces,
            self._room_depth,
        ).depth
        colour = self._with_plate(picture, installed_arm().flange(joints) @ self.truth.T_flange_marker, depth)
        return Frame(colour, depth, 0)

    def _with_plate(
        self, picture: Rendering, T_base_marker: Array, depth: NDArray[np.float32]
    ) -> NDArray[np.uint8]:
        """Draw plate and marker into the picture, and the plate into the depth as well."""
        plate, light = Poster(PLATE_SIZE, PLATE_SIZE, np.full((1, 1), WHITE)), np.full(3, 0.95)
        radiance, near = picture.radiance.copy(), picture.depth.copy()
        for poster in (plate, marker()):
            draw_poster(poster, T_base_marker, self._unit.colour, self._T_base_colour, light, radiance, near)
        spare = np.zeros_like(radiance)
        draw_poster(plate, T_base_marker, self._unit.depth, self.truth.T_base_camera, light, spare, depth)
        return developed(cv2.GaussianBlur(radiance, (0, 0), 0.5))
