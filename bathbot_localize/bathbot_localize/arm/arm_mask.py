"""Where the arm covers the picture, and which points belong to it, from its joint angles alone.

The arm works inside the camera's view. Its shape is a set of capsules; both tests widen them by a
margin for the error of hand-eye, of the outline and of the time between picture and joint angles.
"""

from collections.abc import Iterable, Mapping

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from numba import njit
from numpy.typing import ArrayLike, NDArray

from bathbot_localize.arm.arm_shape import ArmCapsule
from bathbot_localize.surface.registration import view_radius

Array = NDArray[np.float64]
_SIDES = 16  # corners of a sphere's outline
_PIECE = 0.10  # [m] longest piece drawn as one hull: a lens bends long straight edges
_NEAREST = 0.02  # [m] nothing closer to the lens is drawn
_FIXED_POINT = 4  # bits of a pixel's fraction in OpenCV's drawing


def arm_silhouette(
    capsules: Iterable[ArmCapsule], T_base_link: Mapping[str, Array], T_base_camera: ArrayLike,
    camera: Pinhole, margin: float = 0.02,
) -> NDArray[np.bool_]:  # fmt: skip
    """Pixels that the widened arm covers, shape (height, width).

    Args:
        capsules: Shape of the arm.
        T_base_link: Pose of each link, shape (4, 4); links that are missing are not drawn.
        T_base_camera: Maps camera coordinates to the base, shape (4, 4).
        camera: Intrinsics with distortion.
        margin: By which every capsule is widened [m].
    """
    picture = np.zeros((camera.height, camera.width), np.uint8)
    T_camera_base = inverse(T_base_camera)
    pieces, radii = [], []
    for capsule in capsules:
        if capsule.link in T_base_link:
            ends = transform_points(T_camera_base @ T_base_link[capsule.link], [capsule.start, capsule.end])
            pieces += (found := _pieces(ends, capsule.radius + margin))
            radii += [capsule.radius + margin] * len(found)
    if not pieces:
        return picture.astype(bool)
    outlines = sphere_outlines(np.stack(pieces), np.array(radii)[:, None])
    pixels = np.clip(project_widely(camera, outlines), -1e4, 1e4).reshape(len(pieces), -1, 2)
    for corners in np.round(pixels * 2**_FIXED_POINT).astype(np.int32):
        cv2.fillConvexPoly(picture, cv2.convexHull(corners), 1, cv2.LINE_8, _FIXED_POINT)
    return picture.astype(bool)


def sphere_outlines(centres: Array, radii: Array) -> Array:
    """Corners of polygons around the circles where rays of the camera touch spheres.

    Args:
        centres: In the camera's frame [m], shape (..., 3), nowhere inside a sphere.
        radii: Of the spheres [m], broadcast to shape (...).

    Returns:
        Points [m], shape (..., 16, 3).
    """
    distance = np.linalg.norm(centres, axis=-1)
    towards = centres / distance[..., None]
    sine = np.minimum(radii / distance, 0.999)
    # The polygon is drawn around the circle, not in it.
    reach = radii * np.sqrt(1.0 - sine**2) / np.cos(np.pi / _SIDES)
    other = np.where(np.abs(towards[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    side = np.cross(towards, other)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    angle = np.arange(_SIDES)[:, None] * (2.0 * np.pi / _SIDES)
    circle = np.cos(angle) * side[..., None, :] + np.sin(angle) * np.cross(towards, side)[..., None, :]
    return (centres * (1.0 - sine**2)[..., None])[..., None, :] + reach[..., None, None] * circle


def project_widely(camera: Pinhole, points: Array) -> Array:
    """Pixels (u, v), shape (..., 2), of points before the camera, also far outside its picture.

    A lens model holds inside the picture; farther out its polynomial turns back into the picture.
    There the distortion of the picture's border goes on.
    """
    plain = points[..., :2] / points[..., 2:]
    share = np.minimum(1.0, view_radius(camera) / np.maximum(np.linalg.norm(plain, axis=-1), 1e-9))[..., None]
    inside = np.concatenate([plain * share, np.ones_like(share)], axis=-1)
    centre = np.array([camera.cx, camera.cy])
    return centre + (camera.project(inside) - centre) / share


def near_arm(
    points_base: ArrayLike, capsules: Iterable[ArmCapsule], T_base_link: Mapping[str, Array],
    margin: float = 0.02,
) -> NDArray[np.bool_]:  # fmt: skip
    """Points of the widened arm, shape (...).

    Args:
        points_base: Base frame [m], shape (..., 3); NaN is never near.
        capsules: Shape of the arm.
        T_base_link: Pose of each link, shape (4, 4); links that are missing are left out.
        margin: By which every capsule is widened [m].
    """
    points = np.asarray(points_base, dtype=float)
    found = [capsule for capsule in capsules if capsule.link in T_base_link]
    if not found:
        return np.zeros(points.shape[:-1], bool)
    ends = np.stack([
        transform_points(T_base_link[capsule.link], [capsule.start, capsule.end]) for capsule in found
    ])  # fmt: skip
    reach = np.array([capsule.radius + margin for capsule in found])
    return _near(np.ascontiguousarray(points).reshape(-1, 3), ends, reach).reshape(points.shape[:-1])


@njit(cache=True, nogil=True)
def _near(points, ends, reach):
    """Whether each point is within `reach` of one of the segments `ends`, shape (m, 2, 3)."""
    near = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        for j in range(len(ends)):
            length = share = 0.0
            for k in range(3):
                along = ends[j, 1, k] - ends[j, 0, k]
                length += along * along
                share += along * (points[i, k] - ends[j, 0, k])
            share = min(max(share / length, 0.0), 1.0) if length > 0.0 else 0.0
            square = 0.0
            for k in range(3):
                away = points[i, k] - ends[j, 0, k] - share * (ends[j, 1, k] - ends[j, 0, k])
                square += away * away
            if square <= reach[j] * reach[j]:
                near[i] = True
                break
    return near


def _pieces(ends: Array, radius: float) -> list[Array]:
    """Pairs of sphere centres, shape (2, 3), along the part of a segment that lies before the camera."""
    limit = radius + _NEAREST
    start, end = ends
    if max(start[2], end[2]) < limit:
        return []
    if min(start[2], end[2]) < limit:
        inside, outside = (start, end) if start[2] > end[2] else (end, start)
        share = (inside[2] - limit) / (inside[2] - outside[2])
        start, end = inside, inside + share * (outside - inside)
    count = max(int(np.ceil(np.linalg.norm(end - start) / _PIECE)), 1)
    centres = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
    return [centres[i : i + 2] for i in range(count)]
