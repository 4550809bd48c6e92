"""Where the arm covers the picture, and which points belong to it, from its joint angles alone.

The arm works inside the camera's view. Its shape is a set of capsules; both tests widen them by a
margin for the error of hand-eye, of the outline and of the time between picture and joint angles.
"""

from collections.abc import Iterable, Mapping

import cv2
import numpy as np
from bathbot_depthcorr.pinhole import Pinhole
from bathbot_depthcorr.rigid import inverse, transform_points
from numpy.typing import ArrayLike, NDArray

from bathbot_localize.arm_shape import RM65_CAPSULES, ArmCapsule

Array = NDArray[np.float64]
_SIDES = 16        # corners of a sphere's outline
_PIECE = 0.10      # [m] longest piece drawn as one hull: a lens bends long straight edges
_NEAREST = 0.02    # [m] nothing closer to the lens is drawn
_FIXED_POINT = 4   # bits of a pixel's fraction in OpenCV's drawing


def arm_silhouette(
    T_base_link: Mapping[str, Array], T_base_camera: ArrayLike, camera: Pinhole, margin: float = 0.02,
    capsules: Iterable[ArmCapsule] = RM65_CAPSULES,
) -> NDArray[np.bool_]:  # fmt: skip
    """Pixels that the widened arm covers, shape (height, width).

    Args:
        T_base_link: Pose of each link, shape (4, 4); links that are missing are not drawn.
        T_base_camera: Maps camera coordinates to the base, shape (4, 4).
        camera: Intrinsics with distortion.
        margin: By which every capsule is widened [m].
        capsules: Shape of the arm.
    """
    picture = np.zeros((camera.height, camera.width), np.uint8)
    T_camera_base = inverse(T_base_camera)
    for capsule in capsules:
        if capsule.link not in T_base_link:
            continue
        ends = transform_points(T_camera_base @ T_base_link[capsule.link], [capsule.start, capsule.end])
        for centres in _pieces(ends, capsule.radius + margin):
            outline = np.concatenate([sphere_outline(centre, capsule.radius + margin) for centre in centres])
            pixels = camera.project(outline)
            pixels = np.clip(pixels[np.isfinite(pixels).all(axis=1)], -1e4, 1e4)
            if len(pixels) >= 3:
                hull = cv2.convexHull(np.round(pixels * 2**_FIXED_POINT).astype(np.int32))
                cv2.fillConvexPoly(picture, hull, 1, cv2.LINE_8, _FIXED_POINT)
    return picture.astype(bool)


def sphere_outline(centre: Array, radius: float) -> Array:
    """Corners of a polygon around the circle where rays of the camera touch a sphere, shape (16, 3)."""
    distance = float(np.linalg.norm(centre))
    towards = centre / distance
    sine = min(radius / distance, 0.999)
    # The polygon is drawn around the circle, not in it.
    reach = radius * np.sqrt(1.0 - sine**2) / np.cos(np.pi / _SIDES)
    side = np.cross(towards, [1.0, 0.0, 0.0] if abs(towards[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    angle = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    circle = np.outer(np.cos(angle), side) + np.outer(np.sin(angle), np.cross(towards, side))
    return centre * (1.0 - sine**2) + reach * circle


def near_arm(
    points_base: ArrayLike, T_base_link: Mapping[str, Array], margin: float = 0.02,
    capsules: Iterable[ArmCapsule] = RM65_CAPSULES,
) -> NDArray[np.bool_]:  # fmt: skip
    """Points within `margin` [m] of the arm.

    Args:
        points_base: Base frame [m], shape (..., 3); NaN is never near.
        T_base_link: Pose of each link, shape (4, 4); links that are missing are left out.
    """
    points = np.asarray(points_base, dtype=float)
    near = np.zeros(points.shape[:-1], bool)
    flat, found = points.reshape(-1, 3), near.reshape(-1)
    for capsule in capsules:
        if capsule.link not in T_base_link:
            continue
        start, end = transform_points(T_base_link[capsule.link], [capsule.start, capsule.end])
        found |= distance_to_segment(flat, start, end) <= capsule.radius + margin
    return near


def distance_to_segment(points: Array, start: Array, end: Array) -> Array:
    """Distance [m], shape (n,), of points, shape (n, 3), to the segment between two points."""
    along, offset = end - start, points - start
    length = float(along @ along)
    share = np.clip(offset @ along / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(points))
    return np.linalg.norm(offset - share[:, None] * along, axis=1)


def _pieces(ends: Array, radius: float) -> list[Array]:
    """Pairs of sphere centres, shape (2, 3), along a segment in the camera's frame, clipped in front of it."""
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
