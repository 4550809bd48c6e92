"""No correction at all: raw depth and the factory's transform."""

from collections.abc import Sequence

from bathbot_depthcorr.camera_unit import CameraUnit
from bathbot_depthcorr.correction_model import Identity
from bathbot_depthcorr.views import CalibrationView


def fit_uncorrected(views: Sequence[CalibrationView], unit: CameraUnit) -> Identity:
    """Learn nothing from the views."""
    return Identity(unit)
