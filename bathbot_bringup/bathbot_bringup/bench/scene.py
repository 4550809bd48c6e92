"""What the depth corrector is timed on: a camera of any size, a calibration for it, and frames."""

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.models.correction_model import Correction
from bathbot_depthcorr.models.table import DEFAULT_MODEL, judged_models
from numpy.typing import NDArray

SERIAL, TEMPERATURE = "BENCH", 32.0  # of the camera, [deg C]
_HOLE = 8  # [px]
_FOCAL = 641.5 / 1280  # [image widths], of a D455


def bench_camera(width: int, height: int) -> Pinhole:
    """A D455's depth stream at a size [px]."""
    return Pinhole(width, height, _FOCAL * width, _FOCAL * width, 0.5 * width, 0.5 * height)


def bench_corrections(camera: Pinhole, seed: int = 0) -> dict[str, Correction]:
    """One calibration per model of ours; their coefficients are drawn, not fitted."""
    unit = CameraUnit(camera, transform_from(translation=(-0.059, 0.0, 0.0)), SERIAL, TEMPERATURE)
    rng = np.random.default_rng(seed)
    return {name: row.kind.drawn(unit, rng) for name, row in judged_models().items()}


def bench_correction(camera: Pinhole) -> Correction:
    """The calibration of `bench_corrections` with the default model."""
    return bench_corrections(camera)[DEFAULT_MODEL]


def bench_frames(camera: Pinhole, count: int, seed: int = 0) -> list[NDArray[np.float32]]:
    """Frames of a tilted wall [m], shape (H, W), with noise, a blind band at the left and holes."""
    rng = np.random.default_rng(seed)
    directions = camera.directions(camera.pixel_grid())
    wall = (0.9 / (1.0 + 0.25 * directions[..., 0] - 0.1 * directions[..., 1])).astype(np.float32)
    frames = []
    for _ in range(count):
        depth = wall + rng.normal(0.0, 0.002, wall.shape).astype(np.float32)
        holes = rng.random((camera.height // _HOLE + 1, camera.width // _HOLE + 1)) < 0.03
        depth[np.kron(holes, np.ones((_HOLE, _HOLE), bool))[: camera.height, : camera.width]] = np.nan
        depth[:, : camera.width // 16] = np.nan
        frames.append(depth)
    return frames
