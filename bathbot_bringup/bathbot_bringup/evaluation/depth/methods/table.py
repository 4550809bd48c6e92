"""The corrections that the evaluation compares: a row for each method of others, and our models.

The rows of ours stand in `bathbot_depthcorr.models.table`.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Identity
from bathbot_depthcorr.models.table import MODELS, judged_models
from bathbot_depthcorr.views.views import CalibrationView

from bathbot_bringup.evaluation.depth.measures import Fitted
from bathbot_bringup.evaluation.depth.methods.basso import fit_basso
from bathbot_bringup.evaluation.depth.methods.clams import fit_clams
from bathbot_bringup.evaluation.depth.methods.global_quadratic import fit_global_quadratic
from bathbot_bringup.evaluation.depth.methods.herrera import fit_herrera
from bathbot_bringup.evaluation.depth.methods.tare import fit_tare


class Method(NamedTuple):
    """A way to correct depth: how it is fitted, one line about it, its colour in the pictures."""

    fit: Callable[[Sequence[CalibrationView], CameraUnit], Fitted]
    about: str
    colour: str


UNCORRECTED = "none"
_RAW = MODELS[Identity.model]
OTHERS: dict[str, Method] = {
    UNCORRECTED: Method(_RAW.fit, "raw depth, factory transform", _RAW.colour),
    "tare": Method(fit_tare, "one offset of disparity, from the views about 0.75 m", "tab:brown"),
    "global_quadratic": Method(fit_global_quadratic, "one quadratic in Z for the whole image", "tab:gray"),
    "clams": Method(fit_clams, "a factor per 8x6 px and 0.25 m of depth (Teichman 2013)", "tab:olive"),
    "herrera": Method(
        fit_herrera, "a map that fades with disparity, then scale and offset (Herrera 2012)", "tab:green"
    ),
    "basso": Method(
        fit_basso, "quadratics per cell towards the raw middle, then a global map (Basso 2018)", "tab:cyan"
    ),
}


def all_methods() -> dict[str, Method]:
    """What the evaluation compares, in the order of its tables: others' methods, then our models."""
    ours = {name: Method(row.fit, row.about, row.colour) for name, row in judged_models().items()}
    return OTHERS | ours
