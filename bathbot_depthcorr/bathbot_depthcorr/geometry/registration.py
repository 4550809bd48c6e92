"""Corrected depth seen from the colour camera, for a region of the colour image only.

Aligning whole frames costs more than correcting them, and most of it is thrown away. Here the region's
border is led back into the depth image over the range of distances, and only what may show is projected.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.registration_kernel import project_window, splat
from bathbot_depthcorr.geometry.rigid import inverse, rotate, transform_points

Depth = NDArray[np.float32]

_MARGIN = 2  # [px] around the part of the depth image that is projected
_ALONG_BORDER = 9  # points on each edge of the region that are led back


class RegionError(DepthcorrError):
    """A region that the colour image or the depth image does not hold."""


class Region(NamedTuple):
    """A rectangle of the colour image [px]."""

    left: int
    top: int
    width: int
    height: int


def region_camera(camera: Pinhole, region: Region) -> Pinhole:
    """The camera that sees a region of the image only: its centre is counted from the region's corner.

    Raises:
        RegionError: If the region leaves the image.
    """
    left, top, width, height = region
    if min(left, top) < 0 or left + width > camera.width or top + height > camera.height:
        raise RegionError(
            f"region {width}x{height} at ({left}, {top}) leaves the colour image of "
            f"{camera.width}x{camera.height}; choose a smaller one"
        )
    return Pinhole(width, height, camera.fx, camera.fy, camera.cx - left, camera.cy - top, camera.distortion)


class Registration:
    """Carries depth to one region of the colour image.

    Attributes:
        camera: Intrinsics of the region: the colour camera's, its centre moved.
        rows: Rows of the depth image that are used.
        columns: Columns of the depth image that are used.
    """

    def __init__(
        self,
        depth_camera: Pinhole,
        colour_camera: Pinhole,
        T_colour_depth: NDArray[np.float64],
        region: Region,
        nearest: float = 0.3,
        farthest: float = 4.0,
    ) -> None:
        """Prepare the rays of the part of the depth image that may show in the region.

        Args:
            depth_camera: Of the corrected depth, rectified.
            colour_camera: Of the region.
            T_colour_depth: Maps points of the depth frame to the colour frame, shape (4, 4).
            region: In the colour image.
            nearest: Least depth that is carried over [m].
            farthest: Greatest depth that is carried over [m].

        Raises:
            RegionError: If the region leaves the colour image or the depth camera does not see it.
        """
        self.camera = region_camera(colour_camera, region)
        self._shape = (depth_camera.height, depth_camera.width)
        self._span = np.array([nearest, farthest], np.float32)
        self.rows, self.columns = self._window(depth_camera, inverse(T_colour_depth))
        directions = depth_camera.directions(depth_camera.pixel_grid()[self.rows, self.columns])
        rays = rotate(T_colour_depth, directions)
        self._rays = np.ascontiguousarray(np.moveaxis(rays, -1, 0), dtype=np.float32)
        self._origin = T_colour_depth[:3, 3].astype(np.float32)
        camera = self.camera
        self._lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.coefficients], np.float32)
        # What one depth pixel covers when its neighbours have no depth, per unit of Z_depth / Z_colour.
        self._footprint = np.float32(camera.fx / depth_camera.fx), np.float32(camera.fy / depth_camera.fy)

    def apply(self, depth: Depth) -> Depth:
        """Give depth in the colour camera's frame [m], shape (height, width) of the region.

        The nearest surface wins. NaN where no depth was seen: behind edges, in holes of the depth image.

        Args:
            depth: Corrected depth [m], shape (H, W) of the depth camera, float32, NaN = none.

        Raises:
            RegionError: If depth has another shape.
        """
        if depth.shape != self._shape:
            raise RegionError(
                f"depth has shape {depth.shape}, the region was prepared for {self._shape}; "
                "was the depth image resized?"
            )
        window = np.ascontiguousarray(depth[self.rows, self.columns], dtype=np.float32)
        places = np.empty((3, *window.shape), np.float32)
        project_window(window, self._rays, self._origin, self._lens, self._span, places)
        patch = np.zeros((self.camera.height, self.camera.width), np.float32)
        splat(window, places, self._footprint, patch)
        return np.where(
            patch > 0.0, np.float32(1.0) / np.maximum(patch, np.float32(1e-6)), np.float32(np.nan)
        )

    def _window(self, depth_camera: Pinhole, T_depth_colour: NDArray[np.float64]) -> tuple[slice, slice]:
        """Rows and columns of the depth image that the region's border spans over the range of depths."""
        across = np.linspace(-0.5, self.camera.width - 0.5, _ALONG_BORDER)
        down = np.linspace(-0.5, self.camera.height - 0.5, _ALONG_BORDER)
        border = [(u, v) for u in across for v in down[[0, -1]]] + [
            (u, v) for u in across[[0, -1]] for v in down
        ]
        points = np.concatenate([self.camera.deproject(border, np.full(len(border), z)) for z in self._span])
        pixels = depth_camera.project(transform_points(T_depth_colour, points))
        low = np.floor(np.nanmin(pixels, axis=0)).astype(int) - _MARGIN
        high = np.ceil(np.nanmax(pixels, axis=0)).astype(int) + _MARGIN + 1
        size = (depth_camera.width, depth_camera.height)
        (left, top), (right, bottom) = np.clip(low, 0, size), np.clip(high, 0, size)
        if left >= right or top >= bottom:
            raise RegionError(
                f"region {self.camera.width}x{self.camera.height} lies where the depth camera sees nothing; "
                "is the depth-to-colour transform right?"
            )
        return slice(top, bottom), slice(left, right)
