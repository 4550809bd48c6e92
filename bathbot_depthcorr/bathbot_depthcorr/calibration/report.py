"""What a calibration found, in numbers and in words."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.calibration.held_out_view import HeldOutView
from bathbot_depthcorr.calibration.learning_curve import LearningPoint
from bathbot_depthcorr.calibration.wall_guards import WallComparison


class CalibrationReport(NamedTuple):
    """What a calibration found; `references` says in words what decides its accuracy.

    Attributes:
        model: Name of the model.
        views: Number of views used, held-out ones included.
        held_out: Errors on held-out views, near to far.
        change: Of the depth -> colour transform against the factory's: turn [rad], move [m], shape (6,).
        focal_change: Focal length of the colour camera from the board against the factory's, relative; NaN
            without a board.
        frame_noise: Of disparity, one pixel of one frame [px].
        raw: Raw depth against the true planes.
        warnings: One line each.
        learning: Errors of fits to fewer views, where asked for, and to all training views.
    """

    model: str
    views: int
    held_out: list[HeldOutView]
    change: NDArray[np.float64]
    focal_change: float
    frame_noise: float
    raw: WallComparison
    warnings: list[str]
    learning: tuple[LearningPoint, ...]

    @property
    def turn(self) -> float:
        """Angle between the depth -> colour transform and the factory's [rad]."""
        return float(np.linalg.norm(self.change[:3]))

    @property
    def move(self) -> float:
        """The same, distance [m]."""
        return float(np.linalg.norm(self.change[3:]))

    @property
    def before(self) -> float:
        """Mean absolute error of raw depth on held-out views [m]."""
        return float(np.mean([view.absolute_before for view in self.held_out]))

    @property
    def after(self) -> float:
        """Mean absolute error of corrected depth on held-out views [m]."""
        return float(np.mean([view.absolute_after for view in self.held_out]))

    def references(self) -> list[str]:
        """What decides the absolute accuracy, and the warnings, one line each."""
        learning = ", ".join(f"{point.views} views {point.error * 1e3:.2f} mm" for point in self.learning)
        focal = f"colour focal length from the board: {self.focal_change:+.3%} against the factory's"
        return [
            f"depth -> colour: {np.rad2deg(self.turn):.3f} deg, {self.move * 1e3:.2f} mm from the factory's",
            *([focal] if np.isfinite(self.focal_change) else []),
            f"raw depth: {self.raw.scale:.4f} times the true distance, disparity shifted by "
            f"{self.raw.shift:+.2f} px",
            f"learning curve, held-out error of patches: {learning}",
            *(f"warning: {warning}" for warning in self.warnings),
        ]

    def numbers(self) -> dict[str, Any]:
        """The report as plain numbers: lengths in [mm], angles in [deg]."""
        names = ("signed", "absolute", "rmse")
        return {
            "model": self.model, "views": self.views,
            "before_mm": 1e3 * self.before, "after_mm": 1e3 * self.after,
            "held_out": [
                {"distance_m": view.distance} | {
                    f"{name}_{when}_mm": 1e3 * getattr(view, f"{name}_{when}")
                    for name in names for when in ("before", "after")
                } for view in self.held_out
            ],
            "turn_deg": np.rad2deg(self.change[:3]).tolist(), "move_mm": (1e3 * self.change[3:]).tolist(),
            "focal_change": self.focal_change, "frame_noise_px": self.frame_noise,
            "raw_scale": self.raw.scale, "raw_shift_px": self.raw.shift,
            "learning": [{"views": point.views, "patches_mm": 1e3 * point.error} for point in self.learning],
            "warnings": self.warnings,
        }  # fmt: skip
