"""Goals of a calibration, and the coach's advice: whoever follows it gets there."""

import numpy as np
import pytest
from bathbot_depthcorr.calibration.coverage import (
    CORNERS,
    DISTANCES,
    EDGES,
    TILTS,
    WANTED,
    ViewPose,
    coverage_of,
    gain_words,
    instruction,
    is_new,
    next_pose,
    pose_of,
)
from bathbot_depthcorr.views.views import CalibrationView
from depthcorr_wall import Sensor, wall
from hypothesis import given, settings
from hypothesis import strategies as st

turns = st.floats(-0.5, 0.5)
view_poses = st.builds(
    ViewPose, st.floats(0.3, 2.5), turns, turns, st.tuples(*[st.booleans()] * 4).map(tuple)
)
SENSOR = Sensor(width=424, height=240, least_depth=0.2)


@given(st.lists(view_poses, max_size=12), view_poses)
def test_a_view_more_never_takes_from_a_goal(poses, another):
    before, after = coverage_of(poses), coverage_of([*poses, another])
    assert all(after.counts[goal] >= before.counts[goal] for goal in WANTED)
    assert 0.0 <= before.share <= after.share <= 1.0
    assert (after.share > before.share) == bool(before.gain(another))


@given(st.lists(view_poses, max_size=12))
def test_counts_do_not_depend_on_the_order(poses):
    assert coverage_of(poses) == coverage_of(poses[::-1])


@given(view_poses)
def test_goals_are_known_and_sides_exclude_each_other(pose):
    assert set(pose.goals) <= set(WANTED)
    assert len(set(pose.goals) & set(DISTANCES)) == (EDGES[0] <= pose.distance < EDGES[-1])
    assert not {"left", "right"} <= set(pose.goals)
    assert not {"up", "down"} <= set(pose.goals)


@given(st.lists(view_poses, max_size=12), view_poses)
def test_a_view_is_never_new_to_itself(poses, pose):
    assert not is_new(pose, [*poses, pose])


@settings(max_examples=25, deadline=None)
@given(st.lists(view_poses, max_size=6), view_poses)
def test_whoever_obeys_covers_everything(poses, present):
    """Each advised pose is new and serves a goal in want, until none is left."""
    for _ in range(40):
        coverage = coverage_of(poses)
        if not coverage.missing:
            break
        advised = next_pose(poses, present)
        assert is_new(advised, poses)
        assert coverage.gain(advised)
        poses, present = [*poses, advised], advised
    assert instruction(poses) == "all is covered"
    assert len(poses) <= 6 + 30


@pytest.mark.parametrize(("tilt_x", "tilt_y", "side"), [
    pytest.param(0.0, 0.3, "left", id="left"), pytest.param(0.0, -0.3, "right", id="right"),
    pytest.param(-0.3, 0.0, "up", id="up"), pytest.param(0.3, 0.0, "down", id="down"),
])  # fmt: skip
def test_sides_are_the_cameras_own(tilt_x, tilt_y, side):
    """The camera looks left of the wall's normal where depth grows to the left."""
    plane = wall(0.8, tilt_x, tilt_y)
    truth = SENSOR.truth(plane)
    beyond = {
        "left": truth[120, 100] - truth[120, 300], "right": truth[120, 300] - truth[120, 100],
        "up": truth[60, 200] - truth[180, 200], "down": truth[180, 200] - truth[60, 200],
    }  # fmt: skip
    assert beyond[side] > 0.0
    pose = pose_of(CalibrationView(truth.astype(np.float32), plane), SENSOR.factory)
    assert set(pose.goals) & set(TILTS) == {side}


def test_a_corner_without_depth_does_not_count():
    depth = SENSOR.truth(wall(0.8)).astype(np.float32)
    depth[:, :40] = np.nan  # always blind at this distance: f B / Z
    assert pose_of(CalibrationView(depth, wall(0.8)), SENSOR.factory).corners == (True,) * 4
    depth[200:, 300:] = np.nan
    assert pose_of(CalibrationView(depth, wall(0.8)), SENSOR.factory).corners == (True, True, True, False)


@pytest.mark.parametrize(("present", "words"), [
    pytest.param(None, "show the board from 0.82 m, turn 16 deg left and 16 deg up", id="no board"),
    pytest.param(ViewPose(0.5, 0.0, 0.0), "hold still", id="in want"),
    pytest.param(ViewPose(2.5, 0.0, 0.0, (False,) * 4), "move closer to 1.70 m", id="too far"),
    pytest.param(ViewPose(0.3, 0.0, 0.0, (False,) * 4), "move back to 0.50 m", id="too near"),
])  # fmt: skip
def test_advice_in_words(present, words):
    assert instruction([], present).startswith(words)


def test_only_a_corner_is_missing():
    enough = [
        ViewPose(near + 0.03 * step, sign * 0.3, other * 0.3, (True, True, True, False))
        for near in EDGES[:-1] for step, (sign, other) in enumerate(((1, 1), (-1, -1), (1, -1)))
    ]  # fmt: skip
    assert set(coverage_of(enough).missing) == {CORNERS[3]}
    assert instruction(enough).startswith("let the wall fill the lower right corner of the picture")


def test_gains_in_words():
    assert gain_words(("0.6-0.75 m", "left", *CORNERS)) == "0.6-0.75 m, turned left, 4 corners"
    assert gain_words((CORNERS[0],)) == "1 corner"
    assert gain_words(()) == "nothing that was missing"
