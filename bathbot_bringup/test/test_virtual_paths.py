"""Paths that would hurt, sent to the driver in virtual time; the judge is the true contact force."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import TARGET, VirtualCell, ready_deg
from bathbot_scrub.arm.errors import ArmError, InvalidPoseError, NotReadyError
from bathbot_scrub.arm.states import State
from bathbot_scrub.segment.segment import Segment, is_refusal

READY = {"home_deg": ready_deg(0.08), "standoff": 0.03, "approach_speed": 0.05}


def touched(region, look=False):
    cell = VirtualCell(region, seed=5, **READY)
    if look:
        cell.look(0.2, 0.2)
        cell.wait(0.5)
    cell.approach()
    cell.wait(0.3)
    return cell


def into(depths, begin=0.0):
    """Poses along the skin from `begin` [m] on, at depths [m] into it, shape (N, 4, 4)."""
    poses, along = np.tile(TARGET, (len(depths), 1, 1)), begin + 0.002 * np.arange(len(depths))
    poses[:, :3, 3] += np.outer(depths, TARGET[:3, 2]) + np.outer(along, TARGET[:3, 1])
    return poses


def send(cell, *segments):
    """Send segments of one path; give what the driver said to the first that it refused."""
    for index, (region, poses) in enumerate(segments):
        try:
            cell.driver.follow(Segment(7, index, index == len(segments) - 1, region, poses, 0.1))
        except ArmError as error:
            return error
    return None


def force_in(cell, seconds=2.5):
    begin = cell.clock()
    cell.wait(seconds)
    return cell.peak(begin)


@pytest.mark.parametrize("look", [False, True], ids=["unseen", "seen"])
@pytest.mark.parametrize("at_once", [False, True], ids=["bit by bit", "at once"])
def test_a_path_into_the_body_is_refused_whatever_it_calls_itself(look, at_once):
    """40 mm into a face, as skin of the trunk."""
    cell = touched("Face_skin", look)
    depths = np.full(20, 0.04) if at_once else np.linspace(0.0, 0.04, 20)
    refused = send(cell, ("Trunk_skin", into(depths)))
    peak = force_in(cell)
    assert isinstance(refused, InvalidPoseError), f"true force {peak:.1f} N"
    assert peak < cell.region.hard_stop
    assert "below the skin" in str(refused)


def test_a_path_that_calls_itself_trunk_raises_no_threshold_of_a_face():
    cell = touched("Face_skin")
    assert send(cell, ("Trunk_skin", into(np.full(20, 0.005)))) is None
    assert cell.driver.snapshot().force_threshold == cell.region.retract
    cell.lean(0.012, 0.02)  # slowly: beyond what a face may feel, below what a trunk may
    assert force_in(cell) < cell.limits.region("Face_skin").hard_stop
    assert cell.state() is not State.CONTACT


def test_a_gentler_path_is_held_to_its_own_threshold():
    cell = touched("Trunk_skin")
    assert send(cell, ("Face_skin", into(np.full(20, 0.003)))) is None
    assert cell.driver.snapshot().force_threshold == cell.limits.region("Face_skin").retract


def test_the_region_does_not_change_within_a_path():
    cell = touched("Face_skin")
    poses = into(np.full(40, 0.004))
    refused = send(cell, ("Face_skin", poses[:20]), ("Trunk_skin", poses[20:]))
    assert isinstance(refused, NotReadyError)
    assert "is of Trunk_skin, path 7 of Face_skin" in str(refused)
    assert cell.driver.snapshot().force_threshold == cell.region.retract


def test_a_later_segment_that_goes_deeper_is_refused_and_the_path_goes_on_to_where_it_was():
    cell = touched("Face_skin")
    refused = send(
        cell,
        ("Face_skin", into(np.full(20, 0.004))),
        ("Face_skin", into(np.linspace(0.004, 0.04, 20), 0.04)),
    )
    assert isinstance(refused, InvalidPoseError)
    assert force_in(cell) < cell.region.retract
    assert cell.state() is State.CONTACT


def test_a_head_that_does_not_point_into_the_skin_is_refused():
    cell = touched("Trunk_skin")
    poses = into(np.full(20, 0.003))
    turned = np.radians(np.linspace(0.0, 80.0, 20))
    for pose, angle in zip(poses, turned, strict=True):
        c, s = np.cos(angle), np.sin(angle)
        pose[:3, :3] = pose[:3, :3] @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    refused = send(cell, ("Trunk_skin", poses))
    assert isinstance(refused, InvalidPoseError)
    assert "80 deg past the skin's normal" in str(refused)


def told_when_idle(cell):
    """What the arm says when it leaves because nothing comes."""
    cell.clock.until(lambda: cell.state() is State.RETRACTING, 6.0)
    return cell.driver.loop.guard.reason


def test_a_refused_segment_keeps_its_cause_whatever_comes_behind_it():
    """The last one does not follow the first: that is not why the path ends there."""
    cell = VirtualCell("Face_skin", seed=5, leave_after=1.0, **READY)
    cell.approach()
    poses = into(np.full(20, 0.004))
    assert send(cell, ("Face_skin", poses), ("Face_skin", into(np.full(20, 0.05), 0.04))) is not None
    for index in (2, 3):
        with pytest.raises(NotReadyError, match=r"path 7: segment 1 was refused: .* below the skin"):
            cell.driver.follow(Segment(7, index, False, "Face_skin", poses, 0.1))
    assert is_refusal(cell.driver.snapshot().reason, 7)
    reason = told_when_idle(cell)
    assert "without anything to do: path 7: segment 1 was refused" in reason
    assert "below the skin" in reason


def test_what_an_idle_head_waits_for_is_named():
    cell = VirtualCell("Trunk_skin", seed=6, leave_after=0.7, **READY)
    cell.approach()
    assert "anything to do: no path has begun" in told_when_idle(cell)
    for last, words in (
        (True, "anything to do: path 7 is followed to its end, and nobody has retracted"),
        (False, "the planner is silent; segment 1 of path 7 has not come"),
        (None, "anything to do: no path has begun"),  # the one before is over
    ):
        cell.clock.until(lambda: cell.state() is State.HOLD, 3.0)
        cell.approach()
        if last is not None:
            cell.driver.follow(Segment(7, 0, last, "Trunk_skin", into(np.full(10, 0.004)), 0.1))
        assert words in told_when_idle(cell)


def test_an_idle_head_that_is_paused_says_so():
    cell = VirtualCell("Trunk_skin", seed=7, leave_after=0.7, **READY)
    cell.approach()
    cell.driver.follow(Segment(7, 0, True, "Trunk_skin", into(np.full(20, 0.004)), 0.1))
    cell.wait(0.3)
    cell.driver.pause()
    assert "it is paused, and nobody has resumed or retracted it" in told_when_idle(cell)


def test_an_approach_that_is_refused_leaves_the_path_as_it_is():
    cell = VirtualCell("Trunk_skin", seed=8, leave_after=0.7, **READY)
    cell.approach()
    cell.driver.follow(Segment(7, 0, False, "Trunk_skin", into(np.full(10, 0.004)), 0.1))
    with pytest.raises(NotReadyError):
        cell.approach()
    assert "the planner is silent; segment 1 of path 7 has not come" in told_when_idle(cell)
