"""A simulated D455 looking at a scene: what its topics carry, frame after frame, and its static frames."""

from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse
from numpy.typing import NDArray

from bathbot_bringup.sim.camera.calibration_scene import ChessboardView, MarkerView
from bathbot_bringup.sim.camera.d455 import D455, Air
from bathbot_bringup.sim.camera.d455_unit import D455Unit
from bathbot_bringup.sim.camera.scene_camera import BathroomView, SceneView
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_bringup.sim.scene import T_LINK_OPTICAL, BathroomScene

ARM_SILENCE = 2.0
"""Time after which the last joint angles heard are no longer drawn [s]."""
AT_ONCE = 0.2
"""Age of the last joint angles heard up to which a picture shows their moment [s]."""
NOISE_PICTURES = 4  # drawn once, then shifted about: drawing noise anew costs more than drawing the person


class Shot(NamedTuple):
    """One pair of pictures: sRGB (H, W, 3) uint8, and depth [m] in whole mm, NaN = none, shape (H, W)."""

    colour: NDArray[np.uint8]
    depth: NDArray[np.float32]


class ColourNoise:
    """Sensor noise of the colour picture."""

    def __init__(self, shape: tuple[int, int], strength: float, seed: int) -> None:
        """Draw it.

        Args:
            shape: Height and width [px].
            strength: Rms, of 255.
            seed: Of the noise.
        """
        rng = np.random.default_rng([seed, 61])
        self._fields = [
            np.round(strength * rng.standard_normal((*shape, 3), dtype=np.float32)).astype(np.int16)
            for _ in range(NOISE_PICTURES if strength > 0.0 else 0)
        ]

    def add(self, colour: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
        """The picture with one frame's noise."""
        if not self._fields:
            return colour
        field = self._fields[rng.integers(len(self._fields))]
        flips = tuple(slice(None, None, step) for step in rng.choice((-1, 1), 2))
        return cv2.add(colour, np.ascontiguousarray(field[flips]), dtype=cv2.CV_8U)


class D455Camera:
    """The unit, the scene before it and the noise of its frames."""

    def __init__(self, settings: SimCameraSettings) -> None:
        """Set the scene.

        Raises:
            BringupError: If the settings describe none.
        """
        sensor = D455(settings.sensor_seed, settings.errors(), settings.width, settings.height)
        self.unit, self._sensor, self._celsius = sensor.unit, sensor, settings.celsius
        self._view = _view(settings, sensor)
        self._noise = ColourNoise((settings.height, settings.width), settings.colour_noise, settings.seed)
        scenario = settings.motion()
        self._air = (
            Air(scenario.wetness, scenario.steam, scenario.drops) if settings.scene == "bathroom" else Air()
        )
        self._rng = np.random.default_rng([settings.seed, settings.sensor_seed, 62])
        self._arm: tuple[NDArray[np.float64] | None, float] = (None, -np.inf)
        self._shown = -np.inf

    def hear_arm(self, joints: NDArray[np.float64], stamp: float) -> None:
        """Take note of where the arm was at `stamp` [s]: joint angles [rad], shape (6,)."""
        self._arm = (joints, stamp)

    def next_moment(self, now: float) -> tuple[float, NDArray[np.float64] | None]:
        """What the picture taken at `now` [s] shows: a moment [s], and the arm's joint angles there.

        A shutter shows all at one moment. Joint angles reach a busy simulator late, so the moment is theirs
        where they are new; without any for long the arm is gone (None). Moments never come twice.
        """
        joints, stamp = self._arm
        self._shown = stamp if self._shown < stamp <= now and now - stamp < AT_ONCE else now
        return self._shown, joints if now - stamp < ARM_SILENCE else None

    def shoot(self, t: float, joints: NDArray[np.float64] | None = None) -> Shot:
        """Take a pair of pictures.

        Args:
            t: Time of the scene [s].
            joints: Angles of the arm [rad], shape (6,); None: no arm.
        """
        frame = self._view.frame(t, joints)
        depth = self._sensor.measure(
            frame.depth, self._rng, pose=frame.pose, celsius=self._celsius, air=self._air
        )
        metres = np.where(depth > 0, depth * np.float32(0.001), np.float32(np.nan))
        return Shot(self._noise.add(frame.colour, self._rng), metres)


def _view(settings: SimCameraSettings, sensor: D455) -> SceneView:
    """What the settings put before the camera."""
    if settings.scene == "chessboard":
        return ChessboardView(sensor.unit, settings.poses, settings.hold, settings.seed)
    if settings.scene == "aruco":
        return MarkerView(sensor.unit, settings.sensor_seed)
    return BathroomView(BathroomScene(settings.seed), settings.motion(), sensor.unit)


def camera_frames(unit: D455Unit) -> list[tuple[str, str, NDArray[np.float64]]]:
    """Frames as realsense2_camera names them: parent, child, transform (child to parent), by the factory.

    camera_link sits at the depth camera with x forward, y left, z up.
    """
    T_link_colour_optical = T_LINK_OPTICAL @ inverse(unit.published_T_colour_depth)
    return [
        ("camera_link", "camera_depth_frame", np.eye(4)),
        ("camera_depth_frame", "camera_depth_optical_frame", T_LINK_OPTICAL),
        ("camera_link", "camera_color_frame", T_link_colour_optical @ inverse(T_LINK_OPTICAL)),
        ("camera_color_frame", "camera_color_optical_frame", T_LINK_OPTICAL),
    ]
