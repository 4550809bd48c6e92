"""The depth models, one row each: a class, how it is fitted, and what else names it.

The class gives the name that files and commands use (`Correction.model`). Commands, bench and evaluation
read this table, so that a new model is one class and one row.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction, Identity
from bathbot_depthcorr.models.disparity_fit import fit_disparity_spline
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.models.two_imager import TwoImager
from bathbot_depthcorr.models.two_imager_fit import fit_two_imager
from bathbot_depthcorr.models.two_stage import TwoStage
from bathbot_depthcorr.models.two_stage_fit import fit_two_stage
from bathbot_depthcorr.views.views import CalibrationView

Fit = Callable[[Sequence[CalibrationView], CameraUnit], Correction]


class DepthModel(NamedTuple):
    """A row.

    Attributes:
        kind: Its class.
        fit: Makes one from walls seen by a camera with the factory's depth -> colour transform.
        about: One line for the help of `bathbot calibrate depth` and the evaluation.
        colour: In the pictures of the evaluation, a name of matplotlib's.
        judged: Whether bench and evaluation show it as one of ours.
    """

    kind: type[Correction]
    fit: Fit
    about: str
    colour: str
    judged: bool = True


MODELS: dict[str, DepthModel] = {
    row.kind.model: row
    for row in (
        DepthModel(
            DisparitySpline, fit_disparity_spline,
            "bathbot's default: splines and ripple in disparity", "tab:blue",
        ),
        DepthModel(
            TwoStage, fit_two_stage,
            "the paper's: quadratics per cell, then one for all", "tab:orange",
        ),
        DepthModel(
            TwoImager, fit_two_imager,
            "splines and ripple in disparity, a map for each imager", "tab:purple",
        ),
        DepthModel(Identity, lambda _, unit: Identity(unit), "leaves depth as it is", "black", judged=False),
    )
}  # fmt: skip
DEFAULT_MODEL = DisparitySpline.model
PAPERS_MODEL = TwoStage.model


def find_fit(model: str) -> Fit:
    """Look up how a model is fitted.

    Raises:
        SettingsError: On an unknown name.
    """
    if model not in MODELS:
        raise SettingsError(f"unknown depth model {model!r}; known are {', '.join(MODELS)}")
    return MODELS[model].fit


def judged_models() -> dict[str, DepthModel]:
    """The models that bench and evaluation show as ours, the default last."""
    shown = {name: row for name, row in MODELS.items() if row.judged and name != DEFAULT_MODEL}
    return shown | {DEFAULT_MODEL: MODELS[DEFAULT_MODEL]}
