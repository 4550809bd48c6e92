"""Every model's fit under the model's name."""

from collections.abc import Callable, Sequence

from bathbot_depthcorr.camera_unit import CameraUnit
from bathbot_depthcorr.correction import MODELS
from bathbot_depthcorr.correction_model import Correction, Identity
from bathbot_depthcorr.disparity_fit import fit_disparity_spline
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.two_imager_fit import fit_two_imager
from bathbot_depthcorr.two_stage_fit import fit_two_stage
from bathbot_depthcorr.views import CalibrationView

DEFAULT_MODEL = "disparity_spline"
Fit = Callable[[Sequence[CalibrationView], CameraUnit], Correction]

FITS: dict[str, Fit] = {
    "disparity_spline": fit_disparity_spline,
    "two_stage": fit_two_stage,
    "two_imager": fit_two_imager,
    "identity": lambda _, unit: Identity(unit),
}


def find_fit(model: str) -> Fit:
    """Look up how a model is fitted.

    Raises:
        SettingsError: On an unknown name.
    """
    if model not in FITS:
        raise SettingsError(f"unknown depth model {model!r}; known are {', '.join(MODELS)}")
    return FITS[model]
