"""Which way gives in to a push in free air, and how fast it is taken."""

import numpy as np
from arm_poses import ARM, HOME, PERIOD, PLANNER, TARGET
from bathbot_scrub.arm.tool_path import retreated
from bathbot_scrub.rm65.paths.free_air import FASTEST, OnWay
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

WAY = PLANNER.to_pose(HOME, retreated(TARGET, 0.06))
SPEED = 0.25
OUTWARD = -TARGET[:3, 2]


@given(share=st.floats(0.2, 0.95), push=st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_whatever_is_taken_goes_where_the_push_leads(share, push):
    way, push = OnWay(WAY, share * WAY.end), np.array(push)
    along = way.yielding(ARM, push, SPEED)
    if along is None:
        return
    heads = ARM.head(along.path.joints[:2])[:, :3, 3]
    assert (heads[1] - heads[0]) @ push > 0.0
    assert_allclose(along.path.joints[0], WAY.at(way.length), atol=1e-9)


def test_a_push_against_the_head_sends_it_back_and_one_from_behind_on():
    way = OnWay(WAY, 0.9 * WAY.end)
    before, behind = (
        ARM.head(WAY.at(way.length + d))[:3, 3] - ARM.head(WAY.at(way.length))[:3, 3] for d in (-0.01, 0.01)
    )
    assert way.yielding(ARM, before, SPEED).sign == -1
    assert way.yielding(ARM, behind, SPEED).sign == 1
    across = np.cross(before, [0.3, 0.2, 0.9])
    assert way.yielding(ARM, across, SPEED) is None


def test_a_way_too_short_to_give_in_is_not_taken():
    way = OnWay(WAY, 0.02)
    push = ARM.head(WAY.at(0.0))[:3, 3] - ARM.head(WAY.at(0.02))[:3, 3]
    assert way.yielding(ARM, push, SPEED) is not None
    assert way.yielding(ARM, push, SPEED, least=0.08) is None


def test_where_it_is_after_a_part_of_it_is_known():
    way = OnWay(WAY, 0.8 * WAY.end)
    along = way.back(ARM, SPEED)
    for share in (0.0, 0.4, 1.0):
        there = along.at(share * along.path.end)
        assert_allclose(there.path.at(there.length), along.path.at(share * along.path.end), atol=1e-4)
        assert there.holds(along.path.at(share * along.path.end))
    assert not way.holds(HOME)


def test_the_head_goes_back_as_fast_as_in_a_retract_and_comes_to_rest_gently():
    along = OnWay(WAY, WAY.end).back(ARM, SPEED)
    runner, joints = PathRunner(along.path, Pace(FASTEST, 25.0, 1e4), PERIOD), [along.path.joints[0]]
    while not runner.at_end:
        joints.append(runner.step())
        assert len(joints) < 500
    heads = ARM.head(np.array(joints))[:, :3, 3]
    speeds = np.linalg.norm(np.diff(heads, axis=0), axis=1) / PERIOD
    assert speeds[2] > 0.1
    assert speeds.max() < 1.2 * SPEED
    assert np.abs(np.diff(joints[-15:], 2, axis=0)).max() / PERIOD**2 < np.radians(600.0)
    assert speeds[3:20].mean() > 0.5 * SPEED  # where the joints turn too fast for it, slower
