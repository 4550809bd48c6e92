"""The scrub path as it arrives."""

import numpy as np
import pytest
from arm_poses import PLANNER, joints_at, straight
from bathbot_scrub.arm.errors import NotReadyError, UnreachableError
from bathbot_scrub.rm65.motion.scrub_path import ScrubPath
from bathbot_scrub.segment.segment import Segment
from numpy.testing import assert_allclose


def segment(index, last=False, path_id=1, poses=None, speed=0.04):
    chunk = straight(0.12, 61)[20 * index : 20 * index + 21] if poses is None else poses
    return Segment(path_id, index, last, "Trunk_skin", chunk, speed)


def scrub_path():
    first = straight(0.12, 61)[0]
    return ScrubPath(segment(0), PLANNER, joints_at(first), np.stack([first, first]), 0.1)


def test_segments_join_without_a_gap_and_are_counted():
    path = scrub_path()
    before = path.path
    after = path.extend(segment(1))
    assert_allclose(after.joints[: len(before.joints)], before.joints)
    path.extend(segment(2, last=True))
    assert path.path.end == pytest.approx(0.12, abs=1e-6)
    assert [path.segment_at(s) for s in (0.0, 0.041, 0.12)] == [0, 1, 2]
    assert [path.queued_at(s) for s in (0.0, 0.041, 0.12)] == [3, 2, 0]
    assert path.finished
    assert [path.travelled_at(s) for s in (0.0, 0.041, 0.12)] == pytest.approx([0.0, 0.041, 0.12])


def test_the_way_along_a_path_is_counted_without_the_turns():
    poses = straight(0.02, 11, 0.6)
    path = ScrubPath(segment(0, True, poses=poses), PLANNER, joints_at(poses[0]), poses[[0, 0]], 0.1)
    assert path.path.end > 0.05
    assert path.travelled_at(path.path.end) == pytest.approx(0.02, abs=1e-6)


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        pytest.param(segment(2), "in order", id="skipped"),
        pytest.param(segment(0), "in order", id="again"),
        pytest.param(segment(1, path_id=2), "in order", id="other path"),
        pytest.param(segment(1, poses=np.full((3, 4, 4), np.nan)), "not finite", id="not a number"),
        pytest.param(segment(1, poses=straight(0.12, 61)[50:]), "m apart", id="gap"),
        pytest.param(segment(1, speed=np.nan), "speed", id="speed"),
        pytest.param(segment(1, poses=np.zeros((0, 4, 4))), "no poses", id="empty"),
    ],
)
def test_a_wrong_segment_is_refused_whole(wrong, error):
    path = scrub_path()
    end = path.path.end
    with pytest.raises((NotReadyError, UnreachableError, Exception), match=error):
        path.extend(wrong)
    assert path.path.end == end
    path.extend(segment(1))
