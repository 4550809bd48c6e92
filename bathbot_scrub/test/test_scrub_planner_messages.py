"""Messages to arrays and back."""

import numpy as np
import pytest
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError, OutOfReachError, SurfaceError, TargetLostError
from bathbot_scrub.installed_arm import installed_arm
from bathbot_scrub.job.scrub_job import Code, Outcome, code_of
from bathbot_scrub.messages import (
    joints_from_state,
    path_from_poses,
    report_from_arm,
    result_from_outcome,
)
from numpy.testing import assert_allclose
from sensor_msgs.msg import JointState
from synthetic_skin import somewhere

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState

NAMES = installed_arm().joint_names
POSES = np.array([somewhere(index) for index in range(4)])


def test_path_holds_all_poses_in_the_base_frame():
    path = path_from_poses(POSES, 1.5)
    assert {pose.header.frame_id for pose in path.poses} == {"base_link"}
    assert_allclose([pose.pose.position.x for pose in path.poses], POSES[:, 0, 3])


def test_codes_and_states_are_those_of_the_interfaces():
    for code in Code:
        assert getattr(Scrub.Result, code.name) == code
    for mode in State:
        assert getattr(ArmState, mode.name) == mode


def test_report_and_result():
    state = ArmState(state=2, path_id=5, segment_index=2, segments_queued=3)
    state.distance_along, state.path_done = 0.1, True
    assert report_from_arm(state) == (State.CONTACT, "", 5, 2, 3, 0.1, True)
    result = result_from_outcome(Outcome(Code.TARGET_LOST, "gone", 4, 0.2))
    assert (result.error_code, result.error_msg, result.segments, result.length) == (5, "gone", 4, 0.2)


def test_joints_are_read_by_name():
    names = [f"joint{number}" for number in (6, 5, 4, 3, 2, 1)]
    state = JointState(name=names, position=[6.0, 5.0, 4.0, 3.0, 2.0, 1.0])
    assert_allclose(joints_from_state(state, NAMES), [1, 2, 3, 4, 5, 6])
    with pytest.raises(NotReadyError, match="joint_states names wheel"):
        joints_from_state(JointState(name=["wheel"], position=[0.0]), NAMES)


@pytest.mark.parametrize(
    ("error", "code"),
    [(SurfaceError(""), Code.NO_SURFACE), (OutOfReachError(0.1, 0.4, ""), Code.UNREACHABLE),
     (TargetLostError(""), Code.TARGET_LOST), (NotReadyError(""), Code.NOT_READY)],
)  # fmt: skip
def test_every_error_has_its_code(error, code):
    assert code_of(error) == code
