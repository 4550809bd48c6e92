"""What a path is planned from: all of it as seen last, or the reason why there is no path."""

import numpy as np
import pytest
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError, SurfaceError
from bathbot_scrub.job.scrub_inputs import ScrubInputs
from bathbot_scrub.job.scrub_job import ArmReport
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

REGION, NOW = "Trunk_skin", 1_700_000_000.25
HEAD, JOINTS, SKIN = np.eye(4), np.arange(6.0), np.ones((2, 2, 3))


def inputs(head=True, joints=True, state=State.CONTACT):
    seen = ScrubInputs(ScrubPlannerSettings())
    for mode in (State.FREE, State.FREE, state):
        seen.before.see_arm(ArmReport(mode, "", 0, 0, 0, 0.0, False))
        if mode is State.FREE:
            seen.before.see_surface(Sighting(NOW - 2.0, lambda: SKIN))
            seen.before.see_targets({REGION: np.eye(4)}, NOW - 2.0)
    if head:
        seen.see_head(lambda: HEAD)
    if joints:
        seen.see_joints(lambda: JOINTS)
    return seen


def test_a_task_holds_what_was_seen():
    task = inputs().task(REGION, 0.3, NOW)
    assert task.surface is SKIN
    assert task.stamp == NOW - 2.0
    assert task.T_base_head is HEAD
    assert task.joints is JOINTS
    assert (task.region, task.max_length) == (REGION, 0.3)
    assert [sighting.stamp for sighting in task.recent] == [NOW - 2.0]


def test_the_id_of_a_path_counts_milliseconds_and_fits_the_message():
    seen = inputs()
    first, second = seen.task(REGION, 0.0, NOW).path_id, seen.task(REGION, 0.0, NOW + 0.002).path_id
    assert second - first == 2
    assert 0 <= first < 2**32


@pytest.mark.parametrize("missing", ["head", "joints"])
def test_without_knowing_the_arm_there_is_no_path(missing):
    seen = inputs(**{missing: False})
    assert not seen.knows_arm
    with pytest.raises(NotReadyError, match="no tool_pose or joint_states yet"):
        seen.task(REGION, 0.0, NOW)


def test_without_contact_or_target_there_is_no_path():
    with pytest.raises(NotReadyError, match="FREE, not in CONTACT"):
        inputs(state=State.FREE).task(REGION, 0.0, NOW)
    with pytest.raises(SurfaceError, match="region 'Foot_skin'"):
        inputs().task("Foot_skin", 0.0, NOW)


def test_a_body_counts_for_as_long_as_the_setting_says():
    seen, oldest = inputs(), ScrubPlannerSettings().body_max_age
    assert len(seen.body(NOW)) == 0
    seen.see_body(Sighting(NOW, lambda: SKIN))
    assert seen.knows_body
    assert (seen.body(NOW + 0.9 * oldest) == SKIN.reshape(-1, 3)).all()
    with pytest.raises(NotReadyError, match="the body was last seen"):
        seen.body(NOW + 1.1 * oldest)


@pytest.mark.parametrize(
    "nothing", [np.empty((1, 0, 3)), np.full((1, 5, 3), np.nan)], ids=["empty", "not numbers"]
)
def test_a_body_cloud_without_points_is_unknown_not_nobody(nothing):
    seen = inputs()
    seen.see_body(Sighting(NOW, lambda: nothing))
    with pytest.raises(NotReadyError, match="the body cloud is empty"):
        seen.body(NOW)
