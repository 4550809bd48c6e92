"""What the arm driver does when asked, against the emulated controller in virtual time; exact surfaces."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import TARGET, ready_deg
from bathbot_scrub.arm.errors import (
    ArmSettingsError,
    CanceledError,
    ForceLimitError,
    InvalidPoseError,
    NoContactError,
    NotReadyError,
    UnreachableError,
)
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.motion.approach import Request
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.segment.segment import is_refusal
from emulator_cell import REGION, segments
from near_the_skin import AT_ONCE, at_last, cell_near, off_the_normal, settle, touch
from numpy.testing import assert_allclose


@pytest.fixture
def cell():
    return cell_near()


@pytest.fixture
def touching():
    return touch(cell_near())


def states_during(cell, condition, within, every=0.02):
    """The states seen until something holds."""
    seen, end = set(), cell.clock() + within
    while not condition():
        assert cell.clock() < end, cell.driver.snapshot().reason
        seen.add(cell.state())
        cell.wait(every)
    return seen


def test_a_starved_path_waits_in_contact_and_goes_on(touching):
    driver = touching.driver
    first, second, third = segments()
    driver.follow(first)
    waits = f"waits for segments: segment 1 of path {first.path_id} has not come"
    at_last(touching, lambda: driver.snapshot().reason == waits, 1.5)
    touching.wait(0.2)
    assert touching.state() is State.CONTACT
    assert touching.gap() == pytest.approx(-0.005, abs=2e-4)
    with pytest.raises(NotReadyError, match="in order"):
        driver.follow(third)
    assert is_refusal(driver.snapshot().reason, first.path_id)
    assert "segment 2 was refused" in driver.snapshot().reason
    driver.follow(second)
    driver.follow(third)
    done = states_during(touching, lambda: driver.snapshot().path_done, 1.5)
    assert done == {State.CONTACT}
    assert driver.snapshot().distance_along == pytest.approx(0.06, abs=1e-3)


def test_stop_stops_and_forgets_pause_stops_and_resumes(touching):
    driver = touching.driver
    for segment in segments(speed=0.02):
        driver.follow(segment)
    at_last(touching, lambda: driver.snapshot().distance_along > 0.005, 2.0)
    driver.pause()
    settle(touching)
    assert (touching.state(), driver.snapshot().reason) == (State.HOLD, "paused")
    at = driver.snapshot().distance_along
    touching.wait(0.2)
    assert driver.snapshot().distance_along == at
    assert not touching.moving()
    driver.resume()
    at_last(touching, lambda: driver.snapshot().distance_along > at + 0.005, 1.0)
    driver.stop()
    settle(touching)
    assert touching.state() is State.HOLD
    for refused in (driver.resume, driver.home, lambda: driver.follow(segments()[0])):
        with pytest.raises(NotReadyError):
            refused()
    driver.retract()
    at_last(touching, lambda: touching.state() is State.FREE, 1.5)


@pytest.mark.parametrize(
    ("nearer", "state"),
    [
        pytest.param(0.003, State.HOLD, id="over the limit for leaving"),
        pytest.param(0.007, State.FAULT, id="bristles flat and more"),
    ],
)
def test_a_body_that_moves_into_the_brush_is_left_along_the_normal(touching, nearer, state):
    driver = touching.driver
    touching.lean(nearer, AT_ONCE)
    at_last(touching, lambda: touching.state() in (State.HOLD, State.FAULT), 1.5)
    assert touching.state() is state
    assert "retracted: force" in driver.snapshot().reason
    assert touching.gap() > 0.05
    assert off_the_normal(touching) < 2e-3
    with pytest.raises(NotReadyError, match="arm/resume"):
        driver.home()
    driver.resume()
    driver.home()
    at_last(touching, lambda: driver.snapshot().reason == "at home", 3.0)


def test_no_skin_where_it_should_be(cell):
    cell.lean(-0.05, AT_ONCE)
    with pytest.raises(NoContactError, match="has the person moved"):
        cell.approach()
    assert cell.state() is State.HOLD
    with pytest.raises(NotReadyError, match="arm/retract first"):
        cell.approach()
    cell.driver.retract()
    at_last(cell, lambda: cell.state() is State.FREE, 1.5)


def test_skin_nearer_than_believed_is_felt_all_the_same(cell):
    cell.lean(0.02, AT_ONCE)
    cell.approach()
    settle(cell)
    assert cell.trace.data().compression.max() < 0.010
    assert cell.trace.data().indentation.max() == 0.0
    assert cell.peak() < cell.region.retract


def test_something_in_the_way_to_the_standoff_sends_it_back():
    cell = cell_near(home_deg=ready_deg(0.22))
    cell.lean(0.15, AT_ONCE)
    with pytest.raises(ForceLimitError, match="force"):
        cell.approach()
    cell.wait(1.0)
    assert cell.force() == 0.0
    assert cell.state() is State.HOLD


@pytest.mark.parametrize(
    ("request_", "error"),
    [
        pytest.param({"T_base_target": TARGET * np.nan}, InvalidPoseError, id="not a number"),
        pytest.param(
            {"T_base_target": np.diag([2.0, 1.0, 1.0, 1.0]) @ TARGET}, InvalidPoseError, id="not rigid"
        ),
        pytest.param({"T_base_target": TARGET + 0.5 * np.eye(4, k=3)}, UnreachableError, id="far"),
        pytest.param({"region": "Knee"}, ArmSettingsError, id="region"),
        pytest.param({"standoff": float("nan")}, InvalidPoseError, id="standoff"),
        pytest.param({"standoff": 1e-6}, InvalidPoseError, id="stand-off on the skin"),
        pytest.param({"speed": -1.0}, InvalidPoseError, id="speed"),
        pytest.param({"speed": 0.2}, InvalidPoseError, id="faster than the guard was judged at"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_moves(cell, request_, error):
    before = cell.controller.dynamics.joints
    with pytest.raises(error) as caught:
        cell.approach(**request_)
    assert "\n" not in str(caught.value)
    cell.wait(0.1)
    assert_allclose(cell.controller.dynamics.joints, before)
    assert not cell.trace.data().joint_speeds.any()
    assert cell.state() is State.FREE


def test_a_canceled_approach_stands_still():
    cell, canceled = cell_near(home_deg=ready_deg(0.15)), []
    cell.when(lambda: cell.gap() < 0.1, lambda: canceled.append(True))
    with pytest.raises(CanceledError, match="canceled"):
        cell.driver.approach(Request(TARGET, REGION), lambda: bool(canceled))
    settle(cell)
    assert cell.state() is State.HOLD
    cell.wait(0.2)
    at = cell.controller.dynamics.joints
    assert_allclose(at, cell.driver.loop.where(), atol=1e-3)
    cell.wait(0.3)
    assert_allclose(cell.controller.dynamics.joints, at, atol=1e-4)
    assert cell.gap() > 0.03


def test_segments_far_away_or_beyond_reach_are_refused(touching):
    first = segments()[0]
    away = first.T_base_heads.copy()
    away[:, 2, 3] += 0.5
    for poses, error, words in (
        (away, UnreachableError, "more than 0.35 m"),
        (first.T_base_heads * np.nan, InvalidPoseError, "not finite"),
        (np.zeros((0, 4, 4)), InvalidPoseError, "no poses"),
    ):
        with pytest.raises(error, match=words):
            touching.driver.follow(first._replace(T_base_heads=poses))
    assert touching.state() is State.CONTACT
    assert not touching.driver.loop.moving
    touching.driver.follow(first)


def test_a_path_that_begins_elsewhere_is_reached_over_the_skin(touching):
    driver, begin = touching.driver, touching.clock()
    driver.follow(segments()[2]._replace(index=0))
    seen = states_during(touching, lambda: driver.snapshot().path_done, 4.0)
    assert seen == {State.CONTACT}
    data = touching.trace.data()
    highest = -data.compression[data.stamp >= begin].min()
    assert highest == pytest.approx(0.03 - 0.002, abs=0.004)


def test_a_full_queue_refuses():
    driver = touch(cell_near(queue_length=2)).driver
    pieces = segments(count=4, speed=0.005)
    driver.follow(pieces[0])
    driver.follow(pieces[1])
    with pytest.raises(NotReadyError, match="2 segments wait"):
        driver.follow(pieces[2])


def test_an_arm_that_lags_counts_as_standing_where_it_was_told_to_and_later_where_it_is(cell):
    loop = cell.driver.loop
    cell.driver.moves.to_joints(loop.standing() + 0.05, 1.0)
    cell.wait(0.2)
    measured = cell.driver.link.sample.joints
    assert_allclose(measured, cell.controller.dynamics.joints, atol=1e-4)
    loop.motion.command = measured + 0.05
    loop._rest = 0.0  # set here, for nobody else can make an arm lag and stand still at once
    just_come = loop.where()
    loop._rest = 0.4
    long_after = loop.where()
    assert_allclose(just_come, measured + 0.05)
    assert_allclose(long_after, measured, atol=1e-3)


def test_a_motion_that_is_refused_as_it_begins_leaves_the_arm_in_hold(cell):
    driver, loop = cell.driver, cell.driver.loop
    start = loop.standing()
    driver.moves.to_joints(start + 0.05, 1.0)
    path = driver.planner.joint_path(start, start + 0.1)
    loop.motion.command = start + 0.05  # where it stands, however long ago it came
    loop.guard.begin_approach(driver.limits.gentlest(), "a test")
    with pytest.raises(NotReadyError, match="elsewhere"):
        loop.begin(path, driver.planner.joint_pace, MotionKind.PROGRAM)
    assert cell.state() is State.HOLD
    assert "elsewhere" in driver.snapshot().reason
    driver.moves.to_joints(start, 1.0)
    assert cell.state() is State.FREE
