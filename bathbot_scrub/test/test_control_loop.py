"""The control loop in virtual time: leaving, braking, going on, and what each must not do."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, JOINT_PACE, PERIOD, TARGET, TOUCH
from bathbot_scrub.arm.errors import CollisionError, NotReadyError, UnreachableError
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from loop_cell import OUTWARD, LoopCell
from numpy.testing import assert_allclose


@pytest.fixture
def cell():
    return LoopCell()


def retract(cell):
    with cell.loop.lock:
        cell.loop.leave(cell.loop.alarm())


def no_way(monkeypatch, cell):
    """Let there be no way straight back any more."""

    def refuse(*_):
        raise UnreachableError("no way straight back")

    monkeypatch.setattr(cell.loop._retract_path, "path", refuse)


def test_a_retract_leaves_along_the_outward_normal_and_ends_free(cell):
    cell.in_contact()
    before = cell.gap()
    retract(cell)
    assert cell.state is State.RETRACTING
    cell.press(0.0)
    cell.until(lambda: cell.state is State.FREE)
    offset = cell.head()[:3, 3] - TARGET[:3, 3]
    assert cell.gap() - before == pytest.approx(0.10, abs=1e-3)
    assert np.linalg.norm(np.cross(offset, OUTWARD)) < 1e-3
    assert cell.loop.guard.reason == "retracted"


@pytest.mark.parametrize("after", [1, 5, 20, 40])
def test_a_retract_asked_again_while_it_leaves_changes_nothing(after):
    ways = []
    for again in (False, True):
        cell = LoopCell()
        cell.in_contact()
        begin = len(cell.link.told_joints)
        retract(cell)
        cell.press(0.0)
        cell.step(after)
        if again:
            retract(cell)
        cell.until(lambda cell=cell: cell.state is State.FREE)
        ways.append(np.array(cell.link.told_joints[begin:]))
        assert cell.speeds(begin).max() < 1.05 * cell.settings.retract_speed
    assert_allclose(ways[1], ways[0], atol=1e-12)


def test_a_retract_asked_again_in_transit_changes_nothing(cell):
    """Half-way through free air it goes back as it came, 0.8 rad at most; asked five times still so."""
    cell.on_the_way()
    cell.step(100)
    turned, begin = cell.link.joints.copy(), len(cell.link.told_joints)
    for _ in range(5):
        retract(cell)
        cell.step(5)
    cell.until(lambda: cell.state is State.FREE)
    told = np.array(cell.link.told_joints[begin:])
    assert np.abs(told - turned).max() < 0.95
    assert np.abs(np.diff(told, axis=0)).max() < 1.5 * JOINT_PACE.speed * PERIOD


def test_a_retract_without_a_way_leaves_everything_as_it_was(monkeypatch, cell):
    cell.in_contact()
    cell.scrub()
    cell.step(60)
    no_way(monkeypatch, cell)
    begin = len(cell.link.told_joints)
    for _ in range(5):
        with pytest.raises(UnreachableError):
            retract(cell)
        cell.step(5)
    assert (cell.state, cell.loop.motion.kind) == (State.CONTACT, MotionKind.SCRUB)
    assert cell.speeds(begin).max() == pytest.approx(0.05, rel=0.02)  # stepped once a period, not twice


def test_pressed_without_a_way_it_brakes_and_says_so(monkeypatch, cell):
    cell.in_contact()
    cell.scrub()
    cell.step(60)
    no_way(monkeypatch, cell)
    begin = len(cell.link.told_joints)
    cell.press(12.0)
    cell.step(40)
    assert cell.state is State.FAULT
    assert "no way straight back" in cell.loop.guard.reason
    assert len(cell.log) == 1
    speeds = cell.speeds(begin)
    assert speeds.max() < 0.051
    assert speeds[-1] < 1e-9


def test_what_scrubs_brakes_while_it_leaves(cell):
    """In the end the head is straight above where it came to rest: the way along the skin is short."""
    cell.in_contact()
    cell.scrub(speed=0.10)
    cell.step(60)
    at = cell.head()[:3, 3]
    cell.press(12.0)
    cell.step()
    assert cell.state is State.RETRACTING
    cell.press(0.0)
    cell.until(lambda: cell.state is State.HOLD)
    offset = cell.head()[:3, 3] - at
    along = abs(offset @ TARGET[:3, 1])
    assert 0.0005 < along < 0.006
    assert offset @ OUTWARD == pytest.approx(0.10, abs=2e-3)


def test_who_is_pressed_goes_away_from_the_skin_though_the_line_was_planned_elsewhere(cell):
    """The line that is ready is shifted to where the head has come to, never to the other side."""
    cell.in_contact()
    cell.step(2)
    ready = cell.loop._retract_path._ready
    shifted = ready.joints[0] + 0.008 * np.array([1.0, -0.5, 0.3, 0.0, 0.2, 0.0])
    path = cell.loop._retract_path.path(shifted)
    assert_allclose(path.joints[0], shifted, atol=1e-12)
    assert_allclose(np.diff(path.joints, axis=0), np.diff(ready.joints, axis=0), atol=1e-12)


def test_leaving_someone_who_follows_is_refused_where_something_is_known(cell):
    cell.in_contact()
    retract(cell)
    cell.press(0.0)
    cell.until(lambda: cell.gap() > 0.03)
    elbow = ARM.link_frames(cell.link.joints)[3, :3, 3]
    cell.around.see(elbow + 0.08 * np.random.default_rng(0).normal(size=(4000, 3)), cell.now)
    with pytest.raises(CollisionError):
        cell.loop.motion.way_off_follower(cell.loop.where())
    begin = len(cell.link.told_joints)
    cell.press(12.0)
    cell.step(60)
    assert cell.state is State.FAULT
    assert "the body" in cell.loop.guard.reason
    assert cell.speeds(begin)[-1] < 1e-9


def test_who_follows_while_it_leaves_is_left_on_at_the_same_speed(cell):
    cell.in_contact()
    retract(cell)
    cell.press(0.0)
    cell.until(lambda: cell.gap() > 0.03)
    begin = len(cell.link.told_joints)
    cell.press(12.0)
    cell.step()
    cell.press(0.0)
    cell.until(lambda: cell.state in (State.HOLD, State.FREE))
    assert cell.gap() > 0.09  # on from where it was pressed again, as far as the arm reaches back
    assert cell.speeds(begin).max() < 1.05 * cell.settings.retract_speed


def test_comfort_slows_the_scrubbing(cell):
    cell.in_contact()
    cell.scrub(length=0.2)
    cell.step(60)
    begin = len(cell.link.told_joints)
    cell.press(8.0)  # half-way from the comfort band's end to the threshold
    cell.step(60)
    assert cell.state is State.CONTACT
    assert cell.speeds(begin)[-1] == pytest.approx(0.05 * 0.625, rel=0.03)


def test_a_leave_that_is_over_is_not_taken_for_home(cell):
    """Only home ends an approach; a leave ends in FREE as 'retracted', and its touch is over."""
    cell.in_contact()
    retract(cell)
    cell.press(0.0)
    cell.until(lambda: cell.state is State.FREE)
    assert not cell.loop.guard.touching
    with cell.loop.lock:
        cell.loop.guard.begin_approach(cell.loop.guard.region, "going home")
        cell.loop.begin(cell.planner.joint_path(cell.link.joints, HOME), JOINT_PACE, MotionKind.HOME)
    cell.until(lambda: cell.state is State.FREE)
    assert cell.loop.guard.reason == "at home"
    assert_allclose(cell.link.joints, HOME, atol=1e-6)


def test_after_a_pause_of_the_process_motion_begins_from_rest(cell):
    """The controller ended the stream meanwhile and stands: going on at full speed would be a leap."""
    cell.on_the_way()
    cell.step(100)
    before = cell.link.told_joints[-1]
    told = np.abs(before - cell.link.told_joints[-2]).max()
    cell.now += 0.15
    cell.step()
    assert np.abs(cell.link.told_joints[-1] - before).max() < 0.05 * told


def test_silence_brakes_and_the_motion_goes_on_when_it_is_over(cell):
    way = cell.on_the_way()
    cell.step(100)
    cell.link.age = 0.06
    cell.step(22)
    assert cell.loop.motion.at_rest
    cell.link.age = 0.004
    cell.step(10)
    assert cell.loop.motion.at_rest  # not yet: it must have been steady for a while
    cell.until(lambda: cell.loop.motion.runner is None)
    assert cell.state is State.APPROACH
    assert_allclose(cell.link.joints, way.joints[-1], atol=1e-6)


def test_nothing_begins_while_the_arm_moves_or_stands_elsewhere(cell):
    way = cell.on_the_way()
    cell.step(50)
    with pytest.raises(NotReadyError, match="still moves"), cell.loop.lock:
        cell.loop.begin(way, JOINT_PACE, MotionKind.TRANSIT)
    assert cell.state is State.HOLD
    cell.until(lambda: not cell.loop.moving)
    with pytest.raises(NotReadyError, match="planned from elsewhere"), cell.loop.lock:
        cell.loop.begin(cell.planner.joint_path(TOUCH, HOME), JOINT_PACE, MotionKind.HOME)


def test_a_scrub_that_is_hardly_moving_at_an_edge_still_moves(cell):
    """It went on while it counted as idle, and was taken off the skin for having nothing to do."""
    cell.in_contact()
    path = cell.scrub()
    cell.step(30)
    runner = cell.loop.motion.runner
    runner.speed, runner._acceleration = 9e-5, -0.028  # braked before an edge, about to go on
    cell.step()
    assert runner.at_rest  # as slow as that, for a moment
    assert not runner.at_end
    while not runner.at_end:
        assert cell.loop.moving
        cell.step()
    assert cell.state is State.CONTACT
    assert_allclose(cell.link.joints, path.joints[-1], atol=1e-6)
    assert not cell.loop.moving
