"""What every depth correction can do, whatever its model; the identity is the simplest.

A correction belongs to one camera unit: it knows the serial number, the intrinsics and the size it was
made for, and refuses another.
"""

import math
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.files import write_npz
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole

FILE_FORMAT = "bathbot depth correction 1"
FACTORY_NOISE = 0.08  # [px] of disparity, one frame on a textured wall

Depth = NDArray[np.float32]


class DepthShapeError(DepthcorrError):
    """A depth image of another size than the calibration's."""


class Correction(ABC):
    """Turns the depth a camera reports into the depth that is true."""

    model: ClassVar[str]
    noise: float = math.nan  # [px] of one pixel's disparity in one frame; NaN: not known

    def __init__(self, unit: CameraUnit) -> None:
        """Keep the camera this correction belongs to."""
        self.unit = unit

    @property
    def T_colour_depth(self) -> NDArray[np.float64]:
        """Maps points of the depth frame to the colour frame, shape (4, 4); fitted with the map."""
        return self.unit.T_colour_depth

    @property
    def serial(self) -> str:
        """Serial number of the camera, empty if unknown."""
        return self.unit.serial

    @property
    def depth_camera(self) -> Pinhole:
        """Size and intrinsics of the depth stream."""
        return self.unit.depth_camera

    @property
    def temperature(self) -> float:
        """Temperature of the depth chip at calibration [deg C], NaN if unknown."""
        return self.unit.temperature

    def warm_up(self) -> None:
        """Compile what `apply` runs, on an image without depth."""
        self.apply(np.full((self.depth_camera.height, self.depth_camera.width), np.nan, np.float32))

    @abstractmethod
    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none; never gives depth where there was none.

        Args:
            depth: Of the camera.
            out: Where to write, float32, contiguous, shape (H, W), other memory than `depth`; a new array
                by default.

        Returns:
            `out`.
        """

    @abstractmethod
    def sigma(self, depth: Depth) -> Depth:
        """Standard deviation [m], shape (H, W), of corrected depth [m], of one frame; NaN stays NaN."""

    @abstractmethod
    def arrays(self) -> dict[str, NDArray]:
        """What the model must write to its file, beside the camera unit."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, unit: CameraUnit, arrays: dict[str, NDArray]) -> "Correction":
        """Build the correction from what `arrays` gave."""

    @classmethod
    @abstractmethod
    def drawn(cls, unit: CameraUnit, rng: np.random.Generator) -> "Correction":
        """Draw coefficients of a usual size, every part of the model in use: something to time."""

    def check_shape(self, depth: Depth) -> Depth:
        """Give depth as contiguous float32.

        Raises:
            DepthShapeError: If the size is not the calibration's.
        """
        expected = (self.depth_camera.height, self.depth_camera.width)
        if np.shape(depth) != expected:
            raise DepthShapeError(
                f"depth has shape {np.shape(depth)}, calibration is for {expected}; was the image resized?"
            )
        return np.ascontiguousarray(depth, dtype=np.float32)

    def output(self, out: Depth | None) -> Depth:
        """Give a place to write to: `out`, or a new array.

        Raises:
            DepthShapeError: If `out` has another shape, type or layout.
        """
        shape = (self.depth_camera.height, self.depth_camera.width)
        if out is None:
            return np.empty(shape, np.float32)
        if out.shape != shape or out.dtype != np.float32 or not out.flags.c_contiguous:
            raise DepthShapeError(
                f"out is {out.dtype} of shape {out.shape}, needed is contiguous float32 of shape {shape}"
            )
        return out

    def save(self, path: Path | str) -> None:
        """Write the correction to an .npz file; an interrupted write leaves the old file.

        Raises:
            CalibrationFileError: If the folder is missing or not writable.
        """
        camera = self.depth_camera
        contents: dict[str, Any] = {
            "format": FILE_FORMAT, "model": self.model, "serial": self.serial,
            "size": np.array([camera.width, camera.height]),
            "intrinsics": np.array([camera.fx, camera.fy, camera.cx, camera.cy]),
            "T_colour_depth": self.T_colour_depth, "temperature": self.temperature,
            "baseline": self.unit.baseline, **self.arrays(),
        }  # fmt: skip
        write_npz(Path(path), contents)


class Identity(Correction):
    """Leaves depth as it is; its uncertainty is that of an uncorrected D455."""

    model = "identity"

    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Give a copy of depth [m], shape (H, W)."""
        depth, out = self.check_shape(depth), self.output(out)
        np.copyto(out, depth)
        return out

    def sigma(self, depth: Depth) -> Depth:
        """Noise of one frame and the 2 % that the data sheet allows, added in squares [m]."""
        depth = self.check_shape(depth)
        return np.hypot(
            np.square(depth) * np.float32(FACTORY_NOISE / self.unit.focal_baseline), np.float32(0.02) * depth
        )

    def arrays(self) -> dict[str, NDArray]:
        """Nothing: the identity has no parameters."""
        return {}

    @classmethod
    def from_arrays(cls, unit: CameraUnit, arrays: dict[str, NDArray]) -> "Identity":
        """Build the identity for a camera unit."""
        return cls(unit)

    @classmethod
    def drawn(cls, unit: CameraUnit, rng: np.random.Generator) -> "Identity":
        """Give the identity, which has nothing to draw."""
        return cls(unit)
