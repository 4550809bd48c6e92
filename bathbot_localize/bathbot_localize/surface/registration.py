"""Register a part of the depth picture into the colour picture: only the pixels of one region.

Depth and colour cameras of a D455 stand 59 mm apart, so a depth pixel has no fixed place in the
colour picture. Each square of four neighbouring depth pixels is two triangles in space; they are
drawn into the colour picture with a z-buffer, so nearer skin hides what lies behind it. Along a
triangle inverse depth is linear in the pixel, hence a plane comes out exact, and there are no
holes between pixels. Squares over a depth edge join two different surfaces and are not drawn;
they leave NaN, as do pixels without depth.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from numpy.typing import ArrayLike, NDArray

from bathbot_localize.errors import LocalizeError
from bathbot_localize.surface.triangle_drawing import draw

Array = NDArray[np.float64]
_NEAR, _FAR = 0.25, 3.0  # [m] a bather's skin lies between; bounds the part of the depth picture


class OutsideImageError(LocalizeError):
    """A box that shares no pixel with the picture."""


class Patch(NamedTuple):
    """Points of one rectangle of the colour picture.

    Attributes:
        points: Colour camera's frame [m], shape (h, w, 3), NaN = unknown.
        u: Pixel columns of the points, shape (w,).
        v: Pixel rows of the points, shape (h,).
    """

    points: Array
    u: Array
    v: Array

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Where a point is known, shape (h, w)."""
        return np.isfinite(self.points[..., 2])


@lru_cache(maxsize=4)
def picture_rays(pinhole: Pinhole) -> NDArray[np.float64]:
    """Rays (x/z, y/z, 1) of all pixels, shape (height, width, 3), computed once per camera."""
    rays = pinhole.directions(pinhole.pixel_grid())
    rays.setflags(write=False)
    return rays


@lru_cache(maxsize=4)
def view_radius(camera: Pinhole) -> float:
    """Distance from the axis, as tangent, just beyond the picture's corners: there its lens model ends."""
    u, v = (-0.5, camera.width - 0.5), (-0.5, camera.height - 0.5)
    corners = camera.directions(np.array([(u[i], v[j]) for i in (0, 1) for j in (0, 1)]))
    return 1.05 * float(np.linalg.norm(corners[:, :2], axis=1).max())


def clip_box(box: ArrayLike, width: int, height: int) -> tuple[int, int, int, int]:
    """First and last-plus-one pixel (left, top, right, bottom) whose centres lie in a box.

    Args:
        box: (left, top, right, bottom) [px], (0, 0) at the picture's upper left corner.
        width: Of the picture [px].
        height: Of the picture [px].

    Raises:
        OutsideImageError: When no pixel is left.
    """
    left, top, right, bottom = (float(edge) for edge in np.asarray(box, dtype=float))
    if not np.isfinite([left, top, right, bottom]).all():
        raise OutsideImageError(f"box {left}, {top}, {right}, {bottom} is not finite; is the detector sound?")
    first_u, first_v = max(int(np.ceil(left - 0.5)), 0), max(int(np.ceil(top - 0.5)), 0)
    last_u, last_v = min(int(np.ceil(right - 0.5)), width), min(int(np.ceil(bottom - 0.5)), height)
    if first_u >= last_u or first_v >= last_v:
        raise OutsideImageError(
            f"box {left:.0f}, {top:.0f}, {right:.0f}, {bottom:.0f} lies outside the "
            f"{width}x{height} picture; do detector and colour camera_info belong to the same stream?"
        )
    return first_u, first_v, last_u, last_v


def register(
    depth: NDArray[np.float32], depth_camera: Pinhole, T_colour_depth: ArrayLike, colour_camera: Pinhole,
    box: ArrayLike, stride: int = 1,
) -> Patch:  # fmt: skip
    """Points of the colour picture's pixels inside a box.

    Args:
        depth: Corrected depth [m], shape (H, W), NaN = none, in the depth camera.
        depth_camera: Its intrinsics, without distortion.
        T_colour_depth: Maps depth camera to colour camera coordinates, shape (4, 4).
        colour_camera: Intrinsics with distortion.
        box: (left, top, right, bottom) [px] in the colour picture, clipped to it.
        stride: Every how many-th pixel, in both directions.

    Raises:
        OutsideImageError: When the box shares no pixel with the picture.
    """
    if depth.shape != (depth_camera.height, depth_camera.width):
        raise LocalizeError(
            f"depth picture has shape {depth.shape}, its camera_info says "
            f"{(depth_camera.height, depth_camera.width)}; do both come from one stream?"
        )
    left, top, right, bottom = clip_box(box, colour_camera.width, colour_camera.height)
    u, v = np.arange(left, right, stride), np.arange(top, bottom, stride)
    T_colour_depth = np.asarray(T_colour_depth, dtype=float)
    part = depth_part(depth_camera, T_colour_depth, colour_camera, (left, top, right, bottom))
    buffer = np.zeros((len(v), len(u)))
    draw(
        np.asarray(depth, dtype=np.float32), part, picture_rays(depth_camera), T_colour_depth,
        np.array([colour_camera.fx, colour_camera.fy, colour_camera.cx, colour_camera.cy]),
        colour_camera.coefficients, view_radius(colour_camera),
        (float(left), float(top)), float(stride), buffer,
    )  # fmt: skip
    rays = picture_rays(colour_camera)[top:bottom:stride, left:right:stride]
    with np.errstate(divide="ignore"):
        z = np.where(buffer > 0.0, 1.0 / buffer, np.nan)
    return Patch(rays * z[..., None], u.astype(float), v.astype(float))


def depth_part(
    depth_camera: Pinhole, T_colour_depth: Array, colour_camera: Pinhole, box: tuple[int, int, int, int]
) -> NDArray[np.int64]:
    """Part (left, top, right, bottom) [px] of the depth picture that can fall into a colour box."""
    left, top, right, bottom = box
    u, v = np.meshgrid(np.linspace(left - 2, right + 1, 5), np.linspace(top - 2, bottom + 1, 5))
    rays = colour_camera.directions(np.stack([u, v], axis=-1).reshape(-1, 2))
    points = np.concatenate([rays * _NEAR, rays * _FAR])
    pixels = depth_camera.project(transform_points(inverse(T_colour_depth), points))
    low, high = np.nanmin(pixels, axis=0) - 2.0, np.nanmax(pixels, axis=0) + 3.0
    limit = np.array([depth_camera.width, depth_camera.height])
    low, high = np.clip(low, 0, limit), np.clip(high, 0, limit)
    return np.array([low[0], low[1], high[0], high[1]], dtype=np.int64)
