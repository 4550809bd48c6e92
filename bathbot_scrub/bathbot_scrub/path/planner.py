"""From a surface and a contact target to a scrub path, segment by segment."""

from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse
from numpy.typing import NDArray

from bathbot_scrub.errors import OutOfReachError, TargetLostError
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import Mask, PatchGrid, patch_frame
from bathbot_scrub.path.path_choice import Patch, around_target, candidates, choose_patch, washed
from bathbot_scrub.path.reach import Reach
from bathbot_scrub.path.scan_lines import Ground
from bathbot_scrub.path.segments import Joint, SegmentShaper
from bathbot_scrub.path.surface_map import Sighting, SurfaceMap
from bathbot_scrub.path.tool_pose import head_poses, head_rotations
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.segment import Segment

Array = NDArray[np.float64]
_SHORTEST = 0.03  # a path shorter than this washes nothing [m]


class Task(NamedTuple):
    """What a path is planned from.

    Attributes:
        surface: Organised points in the base frame [m], shape (H, W, 3), NaN where unknown; seen
            before the arm came.
        stamp: Time of the surface [s].
        T_base_target: Contact target, shape (4, 4): z into the skin, y along it.
        T_base_head: Where the head stands in contact, shape (4, 4); nothing: at the target.
        joints: Joint angles there [rad], shape (6,); nothing: reach is not checked.
        max_length: Of the path [m]; 0: the whole patch.
        recent: Surfaces of the last breaths, which tell the mean height of the skin.
        path_id, region: What all segments of the path bear.
    """

    surface: Array
    stamp: float
    T_base_target: Array
    T_base_head: Array | None = None
    joints: Array | None = None
    max_length: float = 0.0
    recent: tuple[Sighting, ...] = ()
    path_id: int = 0
    region: str = ""


class PathPlanner:
    """Plans one path: `poses` is all of it as seen at the start, `next_segment` gives it out in pieces."""

    def __init__(self, task: Task, settings: ScrubPlannerSettings, reach: Reach | None = None) -> None:
        """Choose the patch and the scan lines.

        Raises:
            SurfaceError: No usable skin around the target.
            OutOfReachError: Too little of it within reach.
            TargetLostError: The head does not stand at the target.
        """
        self._settings, self._reach, self._task = settings, reach, task
        frame = patch_frame(task.T_base_target)
        grid = PatchGrid(
            frame,
            settings.patch_length / 2.0 + settings.map_margin,
            settings.patch_width / 2.0 + settings.map_margin,
            settings.cell,
        )
        self.map = SurfaceMap(grid, task.surface, task.stamp, settings)
        for sighting in task.recent:
            self.map.recall(sighting.decode(), sighting.stamp)
        self.grid, self._seen = grid, grid.to_patch(task.surface)
        field = self.map.field()
        self._tip, self._rotation = self._head_in_patch()
        self.poses = self._choose_path(field)
        self._last = self.poses[0]
        self._index, self._given, self.length = 0, 0, 0.0
        self.finished = False
        self.cut_short = ""  # why the path ended before its end; empty: it did not

    @property
    def summary(self) -> str:
        """The path in plain words."""
        length = self._settings.step * (len(self.poses) - 1)
        return f"{length:.2f} m of path on {self.scan.lines} lines; it washes {self.reached:.0%} of the patch"

    @property
    def fraction(self) -> float:
        """Share of the path given out, 0..1."""
        return min(self.length / max(self._settings.step * (len(self.poses) - 1), 1e-9), 1.0)

    def next_segment(self) -> Segment:
        """Plan the next segment on the surface as known now; it ends where the arm cannot follow any more."""
        count = self._settings.segment_points
        poses, self._joint, ends = self._shaper.lay(self._joint, self.map.field(), count)
        rest = len(self.poses) - self._given
        if rest <= len(poses) or (ends and len(poses) <= rest):
            poses, ends = poses[:rest], True
        poses, ends = self._cut(self.grid.T_base_patch @ poses, ends)
        self._given, self._last = self._given + len(poses), poses[-1]
        task, settings = self._task, self._settings
        segment = Segment(
            task.path_id, self._index, ends, task.region, poses, settings.speed, settings.step, self.map.stamp
        )
        self._index, self.finished = self._index + 1, ends
        self.length += self._settings.step * (len(poses) - (segment.index == 0))
        return segment

    def _head_in_patch(self) -> tuple[Array | None, Array | None]:
        """Tip [m] and rotation of the head in contact, in the patch frame."""
        head = self._task.T_base_head
        if head is None:
            return None, None
        offset = float(np.linalg.norm(head[:3, 3] - self._task.T_base_target[:3, 3]))
        if offset > self._settings.max_offset:
            raise TargetLostError(
                f"the head stands {offset * 1000.0:.0f} mm from the contact target, allowed are "
                f"{self._settings.max_offset * 1000.0:.0f} mm; approach the newest target first"
            )
        placed = inverse(self.grid.T_base_patch) @ head
        return placed[:3, 3], placed[:3, :3]

    def _in_reach(self, field: HeightField, patch: Patch) -> Patch:
        """A patch with the ground that the arm can reach; with margins if the target itself allows."""
        if self._reach is None:
            return patch
        margin = self._settings.reach_margin
        for depths, easily in (((-margin, margin), True), ((-margin, margin), False), ((0.0,), False)):
            held = around_target(self._held(field, patch.ground.allowed, depths, easily))
            if held.any():
                break
        return patch._replace(ground=Ground(self.grid, held))

    def _held(self, field: HeightField, allowed: Mask, depths: tuple[float, ...], easily: bool) -> Mask:
        """Cells where the arm can hold the head at the given heights over the skin [m]."""
        rows, columns = np.nonzero(allowed)
        plane = np.column_stack([self.grid.x[columns], self.grid.y[rows]])
        points, normals = field.points_at(plane), field.normals_at(plane)
        rotations = head_rotations(normals, np.tile([1.0, 0.0, 0.0], (len(plane), 1)))
        within = np.ones(len(plane), dtype=bool)
        for depth in depths:
            poses = head_poses(rotations, points + depth * normals)
            within &= self._reach.holds(self.grid.T_base_patch @ poses, easily)
        held = np.zeros_like(allowed)
        held[rows, columns] = within
        return held

    def _choose_path(self, field: HeightField) -> Array:
        """The path that washes most of the patch, as far as the arm can follow it.

        It shall stay in reach when the skin moves by `reach_margin`; where so little is left that it
        would be refused, it need only be in reach as the skin stands now.

        Returns:
            Poses in the base frame, shape (N, 4, 4).

        Raises:
            OutOfReachError: When even that washes too little of what could be washed without limits.
        """
        settings = self._settings
        whole = choose_patch(field, self._seen, settings)
        possible = max(candidate.worth for candidate in candidates(field, whole, settings))
        for margin in (settings.reach_margin, 0.0):
            best, reason, poses = self._best_path(field, whole, margin)
            self.reached = best / max(possible, 1.0)
            if self.reached >= settings.min_reach:
                break
        else:
            reason = reason or "joint limits or length of the arm"
            raise OutOfReachError(self.reached, settings.min_reach, reason)
        if self._task.max_length > 0.0:
            poses = poses[: int(self._task.max_length / settings.step) + 1]
        return poses

    def _best_path(self, field: HeightField, whole: Patch, margin: float) -> tuple[float, str, Array]:
        """The path of most worth, why it ends where it ends, and its poses, shape (N, 4, 4)."""
        settings, radius = self._settings, self._settings.brush_diameter / 2.0
        best, reason, poses = 0.0, "the arm cannot move on from the target", np.empty((0, 4, 4))
        for candidate in candidates(field, self._in_reach(field, whole), settings):
            shaper = SegmentShaper(candidate.path, settings)
            if candidate.worth <= best or shaper.end < _SHORTEST:
                break
            joint = shaper.start(field, self._tip, self._rotation)
            laid = self._whole(shaper, joint, field)
            followed, why = self._followed(laid, margin)
            plane = self.grid.to_patch(laid[:followed, :3, 3])[:, :2]
            worth = candidate.worth * washed(plane, whole, radius).sum()
            worth /= max(washed(candidate.path.plane, whole, radius).sum(), 1)
            if worth > best:
                best, reason, poses = worth, why, laid[:followed]
                self._shaper, self._joint, self.scan = shaper, joint, candidate.path
        return best, reason, poses

    def _followed(self, poses: Array, margin: float) -> tuple[int, str]:
        """How many poses the arm can follow with the skin up to `margin` [m] off, and why it ends there."""
        if self._reach is None:
            return len(poses), ""
        ends = []
        for depth in dict.fromkeys((0.0, margin, -margin)):
            moved = poses.copy()
            moved[:, :3, 3] += depth * poses[:, :3, 2]
            ends.append(self._reach.follow(moved, easily=margin > 0.0))
        return min(ends)

    def _cut(self, poses: Array, ends: bool) -> tuple[Array, bool]:
        """End the path where the skin, as it has moved, takes it out of reach."""
        count, why = (len(poses), "") if self._reach is None else self._reach.advance(poses)
        if count == len(poses):
            return poses, ends
        self.cut_short = why
        return (poses[:count] if count else self._last[None]), True

    def _whole(self, shaper: SegmentShaper, joint: Joint, field: HeightField) -> Array:
        """The path as it would be if the skin stood still from now on, base frame, shape (N, 4, 4)."""
        pieces, ends = [], False
        while not ends:
            poses, joint, ends = shaper.lay(joint, field, self._settings.segment_points)
            pieces.append(poses)
        return self.grid.T_base_patch @ np.concatenate(pieces)
