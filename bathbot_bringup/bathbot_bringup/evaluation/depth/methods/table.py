"""The corrections that the evaluation compares, in the order of its tables."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Identity
from bathbot_depthcorr.models.disparity_fit import fit_disparity_spline
from bathbot_depthcorr.models.two_imager_fit import fit_two_imager
from bathbot_depthcorr.models.two_stage_fit import fit_two_stage
from bathbot_depthcorr.views.views import CalibrationView

from bathbot_bringup.evaluation.depth.measures import Fitted
from bathbot_bringup.evaluation.depth.methods.basso import fit_basso
from bathbot_bringup.evaluation.depth.methods.clams import fit_clams
from bathbot_bringup.evaluation.depth.methods.global_quadratic import fit_global_quadratic
from bathbot_bringup.evaluation.depth.methods.herrera import fit_herrera
from bathbot_bringup.evaluation.depth.methods.tare import fit_tare


def fit_uncorrected(views: Sequence[CalibrationView], unit: CameraUnit) -> Identity:
    """Learn nothing from the views."""
    return Identity(unit)


class Method(NamedTuple):
    """A way to correct depth: how it is fitted, and one line about it."""

    fit: Callable[[Sequence[CalibrationView], CameraUnit], Fitted]
    about: str


METHODS: dict[str, Method] = {
    "none": Method(fit_uncorrected, "raw depth, factory transform"),
    "tare": Method(fit_tare, "one offset of disparity, from the views about 0.75 m"),
    "global_quadratic": Method(fit_global_quadratic, "one quadratic in Z for the whole image"),
    "clams": Method(fit_clams, "a factor per 8x6 px and 0.25 m of depth (Teichman 2013)"),
    "herrera": Method(fit_herrera, "a map that fades with disparity, then scale and offset (Herrera 2012)"),
    "basso": Method(fit_basso, "quadratics per cell towards the raw middle, then a global map (Basso 2018)"),
    "two_stage": Method(fit_two_stage, "the paper's: quadratics per cell, then one for all"),
    "two_imager": Method(fit_two_imager, "splines and ripple in disparity, a map for each imager"),
    "disparity_spline": Method(fit_disparity_spline, "bathbot's default: splines and ripple in disparity"),
}
