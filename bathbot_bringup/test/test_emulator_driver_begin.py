"""How the arm driver begins a motion, against the emulated controller."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from emulator_cell import running, until
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph


@pytest.fixture
def cell():
    with running() as cell:
        until(lambda: cell.driver.snapshot().connected)
        yield cell


def test_an_arm_that_lags_counts_as_standing_where_it_was_told_to_and_later_where_it_is(cell):
    loop = cell.driver.loop
    cell.driver.moves.to_joints(loop.standing() + 0.05, 1.0)
    until(lambda: np.abs(cell.driver.link.sample.joints - cell.emulator.truth().joints).max() < 1e-4)
    with loop.lock:  # nothing is sent meanwhile
        told, measured = loop.motion.command, cell.driver.link.sample.joints
        loop.motion.command = measured + 0.05
        loop._rest = 0.0  # set here, for nobody else can make an arm lag and stand still at once
        just_come = loop.where()
        loop._rest = 0.4
        long_after = loop.where()
        loop.motion.command = told
    assert_allclose(just_come, measured + 0.05)
    assert_allclose(long_after, measured, atol=1e-3)


def test_a_motion_that_is_refused_as_it_begins_leaves_the_arm_in_hold(cell):
    driver, loop = cell.driver, cell.driver.loop
    start = loop.standing()
    driver.moves.to_joints(start + 0.05, 1.0)
    path = driver.planner.joint_path(start, start + 0.1)
    with loop.lock:
        loop.motion.command = start + 0.05  # where it stands, however long ago it came
        loop.guard.begin_approach(driver.limits.gentlest(), "a test")
        with pytest.raises(NotReadyError, match="elsewhere"):
            loop.begin(path, driver.planner.joint_pace, MotionKind.PROGRAM)
    assert cell.state() is State.HOLD
    assert "elsewhere" in driver.snapshot().reason
    driver.moves.to_joints(start, 1.0)
    assert cell.state() is State.FREE
