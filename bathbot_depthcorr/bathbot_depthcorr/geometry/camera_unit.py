"""The one camera a calibration was made for, and its refusal of another."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.pinhole import Pinhole

DEFAULT_BASELINE = 0.095  # [m] between the D455's imagers


class OtherCameraError(DepthcorrError):
    """A correction made for another camera, size or lens."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraUnit:
    """The one camera a correction was made for.

    Attributes:
        depth_camera: Intrinsics of the rectified depth stream at the size in use.
        T_colour_depth: Maps points of the depth frame to the colour frame, shape (4, 4).
        serial: Serial number, empty if unknown.
        temperature: Of the depth chip at calibration [deg C], NaN if unknown.
        baseline: Distance between the stereo imagers [m]; sets the unit of disparity.
    """

    depth_camera: Pinhole
    T_colour_depth: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    serial: str = ""
    temperature: float = float("nan")
    baseline: float = DEFAULT_BASELINE

    @property
    def focal_baseline(self) -> float:
        """Product f B [px m] that turns depth into disparity."""
        return self.depth_camera.fx * self.baseline

    def refuse_other(self, depth_camera: Pinhole, serial: str = "") -> None:
        """Compare with the camera that is connected.

        Raises:
            OtherCameraError: If size, intrinsics (beyond 0.1 px) or a known serial number differ.
        """
        mine, theirs = self.depth_camera, depth_camera
        if (mine.width, mine.height) != (theirs.width, theirs.height):
            raise OtherCameraError(
                f"calibration is for {mine.width}x{mine.height}, camera sends "
                f"{theirs.width}x{theirs.height}; "
                "set the camera's depth profile to the calibrated size or calibrate again"
            )
        for name in ("fx", "fy", "cx", "cy"):
            if abs(getattr(mine, name) - getattr(theirs, name)) > 0.1:
                raise OtherCameraError(
                    f"calibration has {name} {getattr(mine, name):.2f} px, camera has "
                    f"{getattr(theirs, name):.2f} px; "
                    "this is another camera or it was re-calibrated: calibrate again"
                )
        if serial and self.serial and serial != self.serial:
            raise OtherCameraError(
                f"calibration is for camera {self.serial}, connected is {serial}; "
                "use that camera's calibration file"
            )
