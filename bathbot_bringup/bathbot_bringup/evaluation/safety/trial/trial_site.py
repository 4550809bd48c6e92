"""Where on a person's trunk the trials of one seed happen: bare skin that the arm can reach all about."""

from dataclasses import dataclass

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.tool_path import retreated
from numpy.typing import NDArray

from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.trial_plan import REGION
from bathbot_bringup.sim.brush import SkinSurface

Array = NDArray[np.float64]
READY = 0.20  # [m] off the skin, where the arm waits for a trial
_ROOMS = (0.05, 0.04, 0.03)  # [m] about the site that must be skin within reach: the widest there is
_SLOPE = np.cos(np.radians(40.0))  # of the skin about the site
_ROUND = 0.02  # [m] over which the normal is averaged
_BRUSH = 0.72 * SCRUB_HEAD.brush_radius  # [m] from its middle to where the bristles do not give way sideways
_RIM = _BRUSH * np.stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4)], axis=-1)
_FLAT = 0.007  # [m] of relief under the brush
_NEIGHBOURS = 11
_START = 0.15  # [m] off the skin where rays begin
_SIGHT, _PIXEL = 0.13, 0.0025  # [m] to either side of a target, between points


@dataclass(frozen=True)
class TrialSite:
    """A site on the skin with its frame.

    Attributes:
        T_base_site: Origin on the skin, z into it, shape (4, 4).
        ready: Joints with the head at `READY` before it [rad], shape (6,).
        room: Radius about it that is skin within reach [m].
        surface: The skin.
    """

    T_base_site: Array
    ready: Array
    room: float
    surface: SkinSurface

    def target(self, shift: tuple[float, float], heading: float) -> Array:
        """Head pose on the skin beside the site, (4, 4).

        Args:
            shift: Along x and y of the site [m].
            heading: By which y, the direction of a stroke, is turned about z [rad].
        """
        cos, sin = np.cos(heading), np.sin(heading)
        T = self.T_base_site.copy()
        T[:3, :3] = T[:3, :3] @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return facing(self.surface, on_skin(self.surface, T, np.array([self.T_base_site[:3, :2] @ shift])))[0]

    def stroke(self, T_base_target: Array, half: float, step: float, depth: float) -> Array:
        """Head poses along y of a target, to and fro once, shape (N, 4, 4), the head facing the skin.

        From the middle `half` [m] to either side, `step` [m] between poses, `depth` [m] into the skin.
        """
        out = np.arange(0.0, half, step)
        along = np.concatenate([out, half - out, -out, out - half])
        poses = facing(
            self.surface, on_skin(self.surface, T_base_target, along[:, None] * T_base_target[:3, 1])
        )
        poses[:, :3, 3] += depth * poses[:, :3, 2]
        return poses


def on_skin(surface: SkinSurface, T: Array, offsets: Array) -> Array:
    """A pose moved by offsets [m] (N, 3) and then along its z axis onto the skin (N, 4, 4).

    Raises:
        InputError: Where there is none.
    """
    starts = T[:3, 3] + offsets - _START * T[:3, 2]
    distances, _, _ = surface.distance(starts, np.tile(T[:3, 2], (len(starts), 1)), 0.0)
    if not (distances < 2.0 * _START).all():
        raise InputError("there is no skin; choose another place")
    poses = np.tile(T, (len(starts), 1, 1))
    poses[:, :3, 3] = starts + distances[:, None] * T[:3, 2]
    return poses


def facing(surface: SkinSurface, poses: Array) -> Array:
    """Poses on the skin (N, 4, 4), turned so that z is the normal of the skin under the brush.

    Neighbours share their normals, in a circle: a path does not jerk over a wrinkle.
    """
    heights = _heights(surface, poses)
    slopes = 2.0 / (len(_RIM) * _BRUSH**2) * heights[:, 1:] @ _RIM  # of the plane through the rim
    share = min(_NEIGHBOURS, len(poses))
    slopes = np.mean([np.roll(slopes, k - share // 2, axis=0) for k in range(share)], axis=0)
    z = poses[:, :3, 2] - np.einsum("nij,nj->ni", poses[:, :3, :2], slopes)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    y = poses[:, :3, 1] - np.sum(poses[:, :3, 1] * z, axis=1, keepdims=True) * z
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    turned = poses.copy()
    turned[:, :3, :3] = np.stack([np.cross(y, z), y, z], axis=-1)
    return turned


def _heights(surface: SkinSurface, poses: Array) -> Array:
    """How deep the skin lies along z of poses (N, 4, 4) under the middle and the rim of the brush (N, 9) [m].

    Raises:
        InputError: Where there is none.
    """
    offsets = np.vstack([np.zeros((1, 2)), _RIM])
    across = np.einsum("nij,kj->nki", poses[:, :3, :2], offsets)
    starts = poses[:, None, :3, 3] + across - _START * poses[:, None, :3, 2]
    aims = np.repeat(poses[:, :3, 2], len(offsets), axis=0)
    distances, _, _ = surface.distance(starts.reshape(-1, 3), aims, 0.0)
    if not (distances < 2.0 * _START).all():
        raise InputError("the brush would stand over the edge of the body; choose another place")
    return distances.reshape(len(poses), -1) - _START


def seen_skin(surface: SkinSurface, T_base_target: Array) -> Array:
    """Skin about a target as a depth camera before it would see it (N, N, 3) [m]; NaN where none is."""
    steps = np.arange(-_SIGHT, _SIGHT, _PIXEL)
    u, v = np.meshgrid(steps, steps)
    starts = np.stack([u, v, np.full_like(u, -_START)], -1).reshape(-1, 3) @ T_base_target[:3, :3].T
    starts += T_base_target[:3, 3]
    distances, _, _ = surface.distance(starts, np.tile(T_base_target[:3, 2], (len(starts), 1)), 0.0)
    points = starts + np.where(distances < 2.0 * _START, distances, np.nan)[:, None] * T_base_target[:3, 2]
    return points.reshape(*u.shape, 3)


def find_site(surface: SkinSurface, T_base_camera: Array, arm: Arm) -> TrialSite:
    """The site on the trunk, seen from the camera, with most room about it and most for the wrist.

    Raises:
        InputError: When there is none.
    """
    frames = _seen(surface, T_base_camera)
    for room in _ROOMS:
        found = [_reachable(T, room, surface, arm) for T in frames]
        sites = [entry for entry in found if entry is not None]
        if sites:
            return max(sites, key=lambda entry: entry[0])[1]
    raise InputError(f"the arm reaches no place of {REGION} of this person; take another seed")


def _seen(surface: SkinSurface, T_base_camera: Array) -> list[Array]:
    """Frames of skin in a grid of the camera's view: z into the skin, level x."""
    frames = []
    for u in np.linspace(-0.35, 0.35, 15):
        for v in np.linspace(-0.35, 0.35, 15):
            ray = T_base_camera[:3, :3] @ np.array([u, v, 1.0]) / np.sqrt(1.0 + u * u + v * v)
            distances, normals, part = surface.distance(T_base_camera[None, :3, 3], ray[None], 0.0)
            if part == REGION:
                frames.append(_frame(T_base_camera[:3, 3] + distances[0] * ray, -normals[0]))
    return frames


def _frame(origin: Array, z: Array) -> Array:
    z = z / np.linalg.norm(z)
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.stack([x, np.cross(z, x), z], axis=-1), origin
    return T


def _reachable(T: Array, room: float, surface: SkinSurface, arm: Arm) -> tuple[float, TrialSite] | None:
    """The site and how far the wrist is from its flip; None where skin or arm do not reach all about."""
    normals = _normals(surface, T, _ROUND)
    if normals is None:
        return None
    T = _frame(T[:3, 3], -normals.mean(axis=0))
    around = _normals(surface, T, room)
    if around is None or (around @ -T[:3, 2]).min() < _SLOPE:
        return None
    sides = (T[:3, :2] @ (room / _BRUSH * _RIM).T).T
    poses = _even(surface, T, np.vstack([0.5 * sides, sides]))
    if poses is None:
        return None
    solutions = arm.solve_head(np.concatenate([_back(poses, d) for d in (-0.01, 0.05, 0.11)]))
    common = np.isfinite(solutions).all(axis=(0, 2))
    if not common.any():
        return None
    waiting = arm.solve_head(retreated(T, READY))[common]
    if not np.isfinite(waiting).any():
        return None
    bend = float(np.abs(solutions[:, common, 4]).min(axis=0).max())
    return bend, TrialSite(T, nearest(waiting, arm.home, arm.limits), room, surface)


def _even(surface: SkinSurface, T: Array, offsets: Array) -> Array | None:
    """Poses on the skin beside a frame (N, 4, 4); None where the brush would not meet it with all its rim."""
    try:
        poses = np.concatenate([facing(surface, on_skin(surface, T, offset[None])) for offset in offsets])
        return poses if np.ptp(_heights(surface, poses), axis=1).max() < _FLAT else None
    except InputError:
        return None


def _back(poses: Array, distance: float) -> Array:
    """Poses (N, 4, 4) back along their z axes [m]."""
    return poses - distance * np.pad(poses[:, :, 2:3], ((0, 0), (0, 0), (3, 0)))


def _normals(surface: SkinSurface, T: Array, radius: float) -> Array | None:
    """Normals of the skin at a frame and on a circle about it, (9, 3); None where something else is there."""
    angles = np.arange(8) * np.pi / 4
    offsets = np.vstack([np.zeros(2), radius * np.stack([np.cos(angles), np.sin(angles)], -1)])
    normals = []
    for offset in offsets:
        start = T[:3, 3] + T[:3, :2] @ offset - _START * T[:3, 2]
        distances, normal, part = surface.distance(start[None], T[None, :3, 2], 0.0)
        if part != REGION or abs(distances[0] - _START) > radius:
            return None
        normals.append(normal[0])
    return np.array(normals)
