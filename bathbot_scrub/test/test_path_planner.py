"""From a surface and a target to a path, as the node uses it."""

import numpy as np
import pytest
from bathbot_scrub.errors import OutOfReachError, SurfaceError, TargetLostError
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from numpy.testing import assert_allclose
from synthetic_skin import DISTANCE, cylinder, cylinder_normals, moved, plane, somewhere, target

SETTINGS = ScrubPlannerSettings()
RADIUS = 0.15


def finish(planner, see=lambda index: None):
    segments = []
    while not planner.finished:
        see(len(segments))
        segments.append(planner.next_segment())
    return segments, np.concatenate([segment.T_base_heads for segment in segments])


def depth_below(poses, radius=RADIUS):
    return radius - np.hypot(poses[:, 0, 3] - DISTANCE - RADIUS, poses[:, 1, 3])


@pytest.mark.parametrize("travel", [(0, 0, 1), (0, 1, 0), (0, 0.6, -0.8)], ids=["up", "across", "slanting"])
def test_noisy_limb_is_followed(travel):
    """1 mm of depth noise: the path stays within 0.4 mm of where it should run, normals within 2.5 deg."""
    planner = PathPlanner(Task(cylinder(noise=0.001), 5.0, target(travel)), SETTINGS)
    segments, poses = finish(planner)
    assert [segment.index for segment in segments] == list(range(len(segments)))
    assert [segment.last for segment in segments] == [False] * (len(segments) - 1) + [True]
    assert {segment.stamp for segment in segments} == {5.0}
    assert planner.fraction == pytest.approx(1.0)
    assert planner.length == pytest.approx(SETTINGS.step * (len(poses) - 1))
    assert_allclose(depth_below(poses), SETTINGS.compression, atol=4e-4)
    cosine = -np.sum(poses[:, :3, 2] * cylinder_normals(poses[:, :3, 3]), axis=1)
    assert np.degrees(np.arccos(cosine.clip(-1, 1))).max() < 6.0
    assert_allclose(np.linalg.det(poses[:, :3, :3]), 1.0)


def test_segments_equal_the_path_shown_beforehand_while_nothing_moves():
    planner = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS)
    _, poses = finish(planner)
    assert_allclose(poses[:, :3, 3], planner.poses[:, :3, 3], atol=1e-6)


def test_path_moves_with_the_world():
    """Planned in another frame the path is the same path."""
    move = somewhere(7)
    here = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS).poses
    there = PathPlanner(Task(moved(move, cylinder()), 0.0, move @ target()), SETTINGS).poses
    assert_allclose(there, move @ here, atol=1e-6)


def test_replanning_follows_a_shift_of_the_skin():
    planner = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS)
    hidden = moved(np.eye(4), cylinder())
    hidden[:, :, 0] -= 0.003
    hidden[60:, 70:150] = np.nan

    def see(index):
        if index == 3:
            planner.map.see(hidden, 1.0)

    segments, _ = finish(planner, see)
    after = np.concatenate([segment.T_base_heads for segment in segments[3:]])[12:]
    after[:, 0, 3] += 0.003
    assert_allclose(depth_below(after), SETTINGS.compression, atol=2e-4)
    assert segments[3].stamp == 1.0


def test_path_keeps_off_holes():
    """A hole of 40 mm beside the target: no pose comes nearer to it than the margin."""
    surface = plane()
    v, w = surface[..., 1] - 0.0, surface[..., 2] - 0.04
    hole = np.hypot(v, w) < 0.02
    surface[hole] = np.nan
    poses = PathPlanner(Task(surface, 0.0, target()), SETTINGS).poses
    distance = np.hypot(poses[:, 1, 3], poses[:, 2, 3] - 0.04)
    assert distance.min() > 0.02 + SETTINGS.edge_margin - SETTINGS.cell


def test_length_is_limited_on_demand():
    planner = PathPlanner(Task(cylinder(), 0.0, target(), max_length=0.1), SETTINGS)
    segments, poses = finish(planner)
    assert len(poses) == 51
    assert segments[-1].last


def test_path_begins_at_the_head():
    head = target(point=(DISTANCE + 0.002, 0.004, -0.003))
    planner = PathPlanner(Task(cylinder(), 0.0, target(), T_base_head=head), SETTINGS)
    assert_allclose(planner.next_segment().T_base_heads[0, :3, 3], head[:3, 3], atol=1e-9)


def test_head_elsewhere_is_refused():
    head = target(point=(DISTANCE, 0.05, 0.0))
    with pytest.raises(TargetLostError, match="50 mm from the contact target"):
        PathPlanner(Task(cylinder(), 0.0, target(), T_base_head=head), SETTINGS)


def test_empty_surface_is_refused():
    with pytest.raises(SurfaceError):
        PathPlanner(Task(np.full((40, 50, 3), np.nan), 0.0, target()), SETTINGS)


class HalfReach:
    """Holds only poses on one side; stands for the arm."""

    def __init__(self, side):
        self._side = side

    def holds(self, poses, easily=False):
        return self._side * poses[:, 1, 3] > -0.005

    def follow(self, poses, easily=False):
        held = self.holds(poses)
        return (len(poses), "") if held.all() else (int(np.argmin(held)), "out of reach")

    def advance(self, poses):
        return self.follow(poses)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_path_is_trimmed_to_what_is_in_reach(side):
    planner = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS, HalfReach(side))
    assert (side * planner.poses[:, 1, 3]).min() > -0.005
    assert 0.4 < planner.reached < 0.8


@pytest.mark.parametrize("left", [0.0, 0.02])
def test_path_ends_where_the_skin_has_moved_out_of_reach(left):
    class Shrinking(HalfReach):
        limit = np.inf

        def holds(self, poses, easily=False):
            return poses[:, 1, 3] < self.limit

    reach = Shrinking(1.0)
    planner = PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS, reach)
    segments = [planner.next_segment()]
    reach.limit = segments[0].T_base_heads[-1, 1, 3] + left
    while not planner.finished:
        segments.append(planner.next_segment())
    assert segments[-1].last
    assert planner.cut_short == "out of reach"
    assert planner.fraction < 1.0
    assert all(reach.holds(segment.T_base_heads).all() for segment in segments[1:-1])
    assert np.isfinite(segments[-1].T_base_heads).all()
    assert len(segments[-1].T_base_heads) > 0


def test_too_little_in_reach_is_refused():
    class Nothing(HalfReach):
        def holds(self, poses, easily=False):
            return np.abs(poses[:, 1, 3]) + np.abs(poses[:, 2, 3]) < 0.012

    with pytest.raises(OutOfReachError, match="is within reach, at least 40% is needed"):
        PathPlanner(Task(cylinder(), 0.0, target()), SETTINGS, Nothing(1.0))
