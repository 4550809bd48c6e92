"""A stream of joints as a path: it ends at the last frame, never jumps, and forgets what lies far behind."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import JointLimitError, NotReadyError
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.motion.streamed_path import KEPT, LARGEST_FRAME, StreamedPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

START = np.radians([10.0, -30.0, -80.0, 5.0, 40.0, 0.0])
FIRST = np.eye(6)[0]
PACE = Pace(1.0, 2.0, 20.0)
PLANNER = MotionPlanner(RM65("6F"), START, PACE, 0.5)
steps = st.lists(st.lists(st.floats(-0.05, 0.05), min_size=6, max_size=6), min_size=1, max_size=30)


@given(steps)
@settings(max_examples=50)
def test_the_arm_trails_the_frames_and_ends_at_the_last(turns):
    stream, runner, at = StreamedPath(START, PLANNER), None, START
    for turn in turns:
        goal = stream.end + turn
        path, cut = stream.extend(goal, runner.length if runner else 0.0)
        if runner is None:
            runner = PathRunner(path, PACE, 0.01)
        else:
            runner.rebase(path, cut)
        now = runner.step()
        assert np.abs(now - at).max() <= 1.0 * 0.01 + 1e-9
        at = now
    for _ in range(2000):
        at = runner.step()
        if runner.at_end:
            break
    assert_allclose(at, goal, atol=1e-6)


def test_what_lies_far_behind_is_forgotten():
    stream, length, total = StreamedPath(START, PLANNER), 0.0, 0.0
    for _ in range(200):
        path, cut = stream.extend(stream.end + 0.01 * FIRST, length)
        total += cut
        length = path.end
    assert path.end == pytest.approx(KEPT, abs=0.05)
    assert total + path.end == pytest.approx(2.0)
    assert_allclose(path.joints[-1], START + 2.0 * FIRST)


def test_a_frame_too_far_away_is_refused_and_left_out():
    stream = StreamedPath(START, PLANNER)
    with pytest.raises(NotReadyError, match=r"joint 3 turns 10\.3 deg"):
        stream.extend(START + np.radians([0, 0, 10.3, 0, 0, 0]), 0.0)
    assert_allclose(stream.end, START)


def test_a_frame_beyond_a_limit_is_refused_with_the_limit():
    near = START.copy()
    near[4] = RM65_LIMITS.upper[4] - 0.01
    stream = StreamedPath(near, PLANNER)
    with pytest.raises(JointLimitError, match=r"joint 5.*2\.2340"):
        stream.extend(near + LARGEST_FRAME / 2 * np.eye(6)[4], 0.0)
