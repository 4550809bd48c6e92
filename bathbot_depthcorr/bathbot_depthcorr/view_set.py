"""Walls whose true plane is known, and the camera that saw them: what every source of views gives."""

from typing import NamedTuple

from bathbot_depthcorr.camera_unit import CameraUnit
from bathbot_depthcorr.colour_reference import ColourReference
from bathbot_depthcorr.views import CalibrationView


class ViewSet(NamedTuple):
    """Views for one calibration.

    Attributes:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.
        reference: What the board says about the colour camera; None where the planes came otherwise.
        notes: What was left out on reading, one line each.
    """

    views: list[CalibrationView]
    unit: CameraUnit
    reference: ColourReference | None = None
    notes: tuple[str, ...] = ()
