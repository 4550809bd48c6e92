"""Corrections with random coefficients for a small camera."""

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.models.two_imager import TwoImager
from bathbot_depthcorr.models.two_stage import TwoStage

CAMERA = Pinhole(64, 36, 32.0, 32.0, 32.0, 18.0)
UNIT = CameraUnit(CAMERA, transform_from(translation=(-0.059, 0.001, 0.002)), "SN-1", 31.5)


def spline(seed=0, strength=1.0, unit=UNIT):
    rng = np.random.default_rng(seed)
    return DisparitySpline(
        unit, strength * rng.normal(0.0, 0.02, (4, 5)), strength * rng.normal(0.0, 0.1, (6, 8)),
        strength * rng.normal(0.0, 0.05, 4), 0.07, np.full((3, 5, 9), 1e-4),
    )  # fmt: skip


def two_stage(seed=0, strength=1.0):
    rng = np.random.default_rng(seed)
    local = np.array([0.0, 1.0, 0.0]) + strength * rng.normal(0.0, (0.01, 0.2, 0.3), (5, 9, 3))
    return TwoStage(UNIT, local, [0.0, 1.0 + 0.02 * strength, 0.01 * strength], (0.4, 1.8), 0.07)


def two_imager(seed=0, strength=1.0):
    rng = np.random.default_rng(seed)
    maps = strength * rng.normal(0.0, 0.1, (2, 6, 8))
    return TwoImager(
        UNIT, 0.02 * strength, *maps, strength * rng.normal(0.0, 0.05, 4), 0.07, np.full((4, 5, 9), 1e-4)
    )


MAKERS = {"disparity_spline": spline, "two_stage": two_stage, "two_imager": two_imager}
