"""The path in segments (paper, 2.2.2): each is laid on the newest surface and joined smoothly.

A segment is a cubic B-spline of its own through points of the surface as known now, pressed in by
the compression. It starts exactly at the last pose sent, in its direction; where the surface has
moved meanwhile, the step is spread over the first millimetres. So the concatenated segments are one
curve with one tangent, whatever the body did.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from bathbot_scrub.path.bspline import arc_length, chord_parameters, fit, parameters_at, tangents
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.scan_lines import ScanPath
from bathbot_scrub.path.tool_pose import Turning, head_poses, head_rotations, rotation_rates, turned_rotations
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

Array = NDArray[np.float64]
_SITE = 0.004  # between the points a spline goes through [m of plane path]
_SLACK = 1.5  # the head's path may be this much shorter than the plane path where skin bulges out
_TURNING = 40.0  # rate at which an orientation left over is made up for [rad/m]
_HALF_TURN = np.radians(140.0)  # more than this may be turned either way [rad]
_LEAVING = 0.12  # mean slope at which an old surface is left for the new
_BRISTLES = 0.7  # share of the brush's radius: bristles farther out give way sideways
_LEAST_PRESSED = 0.003  # so much the head presses in any hollow, or breathing would lift it off [m]
_LEAST = 0.4  # a rest shorter than this share of a segment is joined to it


class Joint(NamedTuple):
    """Where a path has got to: all that the next segment must fit to, in the patch frame.

    Attributes:
        length: Length along the plane path [m].
        tip: Tip of the bristles [m], shape (3,).
        tangent: Unit tangent there, shape (3,); NaN before the first segment.
        turning: Rotation of the head and how it turns.
    """

    length: float
    tip: Array
    tangent: Array
    turning: Turning


class SegmentShaper:
    """Lays segments of one plane path on a surface."""

    def __init__(self, path: ScanPath, settings: ScrubPlannerSettings) -> None:
        """Keep the plane path and the settings."""
        self._plane, self._lengths = path.plane, path.lengths
        self._settings = settings
        heading = np.unwrap(np.arctan2(*np.diff(path.plane, axis=0).T[::-1]))
        self._winding = float(heading[0] - heading[-1]) if len(heading) else 0.0  # about the head's z [rad]

    @property
    def end(self) -> float:
        """Length of the plane path [m]."""
        return float(self._lengths[-1])

    def start(self, field: HeightField, tip: Array | None, rotation: Array | None) -> Joint:
        """Where the path begins: at the head's tip [m], shape (3,), if known, else on the skin at the target.

        Args:
            field: The skin.
            tip: Of the bristles in the patch frame.
            rotation: Of the head in the patch frame, shape (3, 3).
        """
        at = np.array([0.0])
        tip = self._tips(field, at)[0] if tip is None else tip
        if rotation is None:
            rotation = head_rotations(field.normals_at(self._at(at)), self._heading(at))[0]
        return Joint(0.0, np.asarray(tip), np.full(3, np.nan), Turning(np.asarray(rotation), np.zeros(3)))

    def lay(self, joint: Joint, field: HeightField, count: int) -> tuple[Array, Joint, bool]:
        """Lay the next piece of the path.

        Args:
            joint: Where the piece before has ended.
            field: The skin as known now.
            count: Number of poses wanted; the last piece has more or fewer.

        Returns:
            Poses in the patch frame, shape (N, 4, 4), the joint at their end, and whether the path ends.
        """
        first = bool(np.isnan(joint.tangent).any())
        curve, parameters, sites = self._curve(joint, field, count)
        along, step = arc_length(curve), self._settings.step
        fitting = int(np.floor(along.total / step + 1e-9)) + first
        ends = bool(sites[-1] >= self.end and fitting <= count * (1.0 + _LEAST))
        number = fitting if ends else min(count, fitting)
        if number <= first:  # the path ended within the last step: stand still there
            return head_poses(joint.turning.rotation, joint.tip)[None], joint, True
        # from the joint itself to one step beyond the last pose, which tells its rate of turning
        lengths = step * np.arange(min(number + 2 - first, fitting + 1 - first))
        mu = parameters_at(curve, lengths, along)
        plane_lengths = np.interp(mu, parameters, sites)
        tips, travel = np.asarray(curve(mu)), tangents(curve, mu)
        wanted = head_rotations(field.normals_at(self._at(plane_lengths)), travel)
        wanted = self._faded(wanted, joint.turning.rotation, lengths)
        rates, end = rotation_rates(wanted), number - first
        turning = joint.turning._replace(rate=rates[0]) if first else joint.turning
        threshold = np.radians(self._settings.turn_threshold_deg)
        turned = turned_rotations(wanted[1 : end + 1], turning, rates[1 : end + 1], threshold)
        applied = np.concatenate([turning.rotation[None], turned])
        reached = Joint(float(plane_lengths[end]), tips[end], travel[end], Turning(applied[end], rates[end]))
        return head_poses(applied, tips[: end + 1])[1 - first :], reached, ends

    def _faded(self, wanted: Array, applied: Array, lengths: Array) -> Array:
        """Rotations, shape (N, 3, 3), that gradually leave the one applied at the joint for the wanted."""
        offset = Rotation.from_matrix(wanted[0].T @ applied).as_rotvec()
        angle = float(np.linalg.norm(offset))
        if angle > _HALF_TURN and offset[2] * self._winding < 0.0:
            # half a turn may be made either way: not the one that winds the wrist up further, nor now this
            # way, now that
            offset *= 1.0 - 2.0 * np.pi / angle
        distance = max(self._settings.blend, float(np.linalg.norm(offset)) / _TURNING)
        return wanted @ Rotation.from_rotvec(_fade(lengths / distance)[:, None] * offset).as_matrix()

    def _curve(self, joint: Joint, field: HeightField, count: int) -> tuple[BSpline, Array, Array]:
        """The spline from the joint on; parameters and plane lengths [m] of the points it goes through."""
        wanted = _SLACK * (1.0 + _LEAST) * count * self._settings.step + 4.0 * _SITE
        stop = min(joint.length + wanted, self.end)
        sites = np.arange(joint.length + _SITE, stop, _SITE)
        if len(sites) and stop - sites[-1] < 0.5 * _SITE:
            sites = sites[:-1]
        sites = np.concatenate([[joint.length], sites, [max(stop, joint.length + 1e-6)]])
        tips = self._tips(field, sites)
        offset = joint.tip - tips[0]
        distance = max(self._settings.blend, float(np.linalg.norm(offset)) / _LEAVING)
        tips += _fade((sites - joint.length) / distance)[:, None] * offset
        curve = fit(tips, None if np.isnan(joint.tangent).any() else joint.tangent)
        return curve, chord_parameters(tips), sites

    def _tips(self, field: HeightField, lengths: Array) -> Array:
        """Tips of the bristles on a surface, pressed in, shape (N, 3), patch frame; less so in a hollow."""
        plane, settings = self._at(lengths), self._settings
        room = settings.max_bend - field.relief_at(plane, _BRISTLES * settings.brush_diameter / 2.0)
        pressed = np.clip(room, min(_LEAST_PRESSED, settings.compression), settings.compression)
        return field.points_at(plane) - pressed[:, None] * field.normals_at(plane)

    def _at(self, lengths: Array) -> Array:
        """Plane positions at lengths of the plane path [m], shape (N, 2)."""
        return np.column_stack([np.interp(lengths, self._lengths, self._plane[:, axis]) for axis in (0, 1)])

    def _heading(self, lengths: Array) -> Array:
        """Direction of the plane path, shape (N, 3)."""
        ahead = self._at(np.minimum(lengths + 0.002, self.end)) - self._at(np.maximum(lengths - 0.002, 0.0))
        return np.column_stack([ahead, np.zeros(len(ahead))])


def _fade(part: Array) -> Array:
    """From 1 at 0 to 0 at 1 and beyond, with flat ends."""
    part = np.clip(part, 0.0, 1.0)
    return 1.0 - part**2 * (3.0 - 2.0 * part)
