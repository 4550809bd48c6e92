"""A simulated D455 before a flat wall, for the tests: the truth is known to the last digit."""

from dataclasses import dataclass, field

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.views.views import CalibrationView
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation


def depth_camera(width=848, height=480):
    focal = 641.5 * width / 1280
    return Pinhole(width, height, focal, focal, 0.5003 * width, 0.505 * height)


def colour_camera(width=1280, height=720):
    focal = 632.4 * width / 1280
    return Pinhole(
        width, height, focal, focal * 0.9994, 0.4999 * width, 0.5046 * height,
        (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224),
    )  # fmt: skip


@dataclass
class Sensor:
    """The D455's disparity errors: d_raw = f B / Z + gL(u, v) - gR(u - d, v) + dd0, then ripple and noise."""

    seed: int = 1
    width: int = 848
    height: int = 480
    scale: float = 0.012
    shift: float = -1.0  # [px] at 1280 columns
    field_size: float = 1.0
    ripple: float = 0.04
    frozen: float = 0.05
    temporal: float = 0.05
    quantum: float = 1e-3  # [m], 0 = none
    least_depth: float = 0.35
    camera: Pinhole = field(init=False)
    T_colour_depth: np.ndarray = field(init=False)
    factory: CameraUnit = field(init=False)

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        self.camera = depth_camera(self.width, self.height)
        self.baseline = 0.095
        self.fields = [self._field(rng), self._field(rng)]
        self.T_colour_depth = transform_from(
            Rotation.from_rotvec(rng.normal(0.0, 0.003, 3)).as_matrix(), (-0.059, 0.0003, 0.0002)
        )
        wrong = transform_from(
            Rotation.from_rotvec(np.deg2rad(0.15 * self.field_size) * unit_vector(rng)).as_matrix(),
            0.0009 * self.field_size * unit_vector(rng),
        )
        self.factory = CameraUnit(self.camera, wrong @ self.T_colour_depth, "TEST-1", 30.0, self.baseline)
        self.phase = rng.uniform(0.0, 2.0 * np.pi)

    def _field(self, rng):
        v, u = np.mgrid[: self.height, : self.width]
        x, y = (u - self.width / 2) / (self.width / 2), (v - self.height / 2) / (self.width / 2)
        px = self.width / 1280 * self.field_size
        smooth = gaussian_filter(
            rng.normal(size=(self.height, self.width)), 60 * self.width / 1280, mode="reflect"
        )
        smooth *= 0.06 / smooth.std()
        tilt = rng.normal(0.0, 0.1, 2)
        return px * (tilt[0] * x + tilt[1] * y + rng.uniform(0.15, 0.25) * x * (x * x + y * y) + smooth)

    def clean(self, truth):
        """Depth [m] as the sensor's systematic errors leave it."""
        focal_baseline = self.factory.focal_baseline
        disparity = focal_baseline / truth
        v, u = np.mgrid[: self.height, : self.width]
        matched = np.clip(np.nan_to_num(u - disparity), 0, self.width - 1).astype(int)
        left, right = self.fields
        raw = disparity * (1 - self.scale) + left - right[v, matched] + self.shift * self.width / 1280
        raw = raw + self.ripple * np.sin(2 * np.pi * raw + self.phase)
        return focal_baseline / raw

    def frame(self, truth, rng, frozen, clean=None):
        """One frame of depth [m], float32, NaN = none; `clean` is that of `truth`, if it is known."""
        focal_baseline = self.factory.focal_baseline
        clean = self.clean(truth) if clean is None else clean
        raw = focal_baseline / clean + frozen + blurred(rng, truth.shape, 2.0, self.temporal)
        raw = np.round(raw * 32) / 32 if self.quantum else raw
        depth = focal_baseline / raw
        depth = np.round(depth / self.quantum) * self.quantum if self.quantum else depth
        _, u = np.mgrid[: self.height, : self.width]
        gone = (u < focal_baseline / truth) | (truth < self.least_depth)
        return np.where(gone, np.nan, depth).astype(np.float32)

    def truth(self, plane_colour):
        """True depth [m], shape (H, W), of a wall given in the colour frame."""
        plane = plane_colour.transformed(np.linalg.inv(self.T_colour_depth))
        return plane.depth_along(self.camera.directions(self.camera.pixel_grid()))

    def view(self, plane_colour, rng, frames=4, plane_error=0.0):
        """A calibration view of a wall; `plane_error` [m] moves the reported plane."""
        truth = self.truth(plane_colour)
        frozen = blurred(rng, truth.shape, 3.0, self.frozen)
        clean = self.clean(truth)
        stack = 1.0 / np.stack([self.frame(truth, rng, frozen, clean) for _ in range(frames)])
        spread = float(np.nanmedian(stack.std(axis=0, ddof=1))) if frames > 1 else 0.0
        reported = Plane(plane_colour.normal, plane_colour.offset + rng.normal(0.0, 1.0) * plane_error)
        m = reported.inverse_form
        covariance = np.outer(m, m) * (plane_error / abs(reported.offset)) ** 2
        return CalibrationView(
            (1.0 / stack.mean(axis=0)).astype(np.float32), reported, covariance, frames, spread
        )


def unit_vector(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def blurred(rng, shape, sd, size):
    if size == 0.0:
        return np.zeros(shape)
    noise = gaussian_filter(rng.normal(size=shape), sd, mode="wrap")
    return noise * (size / noise.std())


def wall(distance, tilt_x=0.0, tilt_y=0.0):
    """A wall in the colour frame: distance [m] along the axis, tilts [rad] about x and y."""
    normal = Rotation.from_euler("xy", (tilt_x, tilt_y)).apply((0.0, 0.0, -1.0))
    return Plane(normal, float(normal[2] * distance))


def walls(rng, count, near=0.45, far=1.6, tilt=np.deg2rad(22)):
    """Walls uniform in inverse distance, tilted both ways."""
    distances = 1.0 / np.linspace(1.0 / near, 1.0 / far, count)
    return [wall(z, *rng.uniform(-tilt, tilt, 2)) for z in distances]
