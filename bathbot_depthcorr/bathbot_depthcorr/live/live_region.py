"""A registered region whose cameras become known one after the other, and may change."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.registration import Depth, Region, RegionError, Registration


class View(NamedTuple):
    """Depth of a region in the colour camera's frame [m], NaN = none, and the camera that sees just it."""

    depth: Depth
    camera: Pinhole


class LiveRegion:
    """Keeps a registration that fits the cameras connected.

    Attributes:
        trouble: Why the region cannot be made although all is known; empty otherwise.
    """

    def __init__(self, region: Region, farthest: float) -> None:
        """Start without cameras.

        Args:
            region: Of the colour image; one without width is never made.
            farthest: Depth that is carried over at most [m].
        """
        self._region, self._farthest = region, farthest
        self._depth_camera: Pinhole | None = None
        self._colour_camera: Pinhole | None = None
        self._transform: NDArray[np.float64] | None = None
        self._registration: Registration | None = None
        self.trouble = ""

    def meet_depth_camera(self, camera: Pinhole) -> None:
        """Take note of the depth camera."""
        if camera != self._depth_camera:
            self._depth_camera = camera
            self._prepare()

    def meet_colour_camera(self, camera: Pinhole) -> None:
        """Take note of the colour camera."""
        if camera != self._colour_camera:
            self._colour_camera = camera
            self._prepare()

    def meet_transform(self, T_colour_depth: NDArray[np.float64]) -> None:
        """Take note of where the depth camera stands, shape (4, 4)."""
        if self._transform is None or not np.array_equal(T_colour_depth, self._transform):
            self._transform = T_colour_depth
            self._prepare()

    def apply(self, depth: Depth) -> View | None:
        """Carry depth [m], shape (H, W), to the region; None while that is not possible."""
        registration = self._registration  # another thread may replace it meanwhile
        return View(registration.apply(depth), registration.camera) if registration is not None else None

    def _prepare(self) -> None:
        self._registration, self.trouble = None, ""
        known = (self._depth_camera, self._colour_camera, self._transform)
        if not self._region.width or any(part is None for part in known):
            return
        try:
            made = Registration(
                self._depth_camera, self._colour_camera, self._transform, self._region,
                farthest=self._farthest,
            )  # fmt: skip
        except RegionError as error:
            self.trouble = str(error)
            return
        camera = self._depth_camera
        made.apply(np.full((camera.height, camera.width), np.nan, np.float32))  # compiles
        self._registration = made
