"""The arm driver against the emulated controller over TCP and UDP, with exact surfaces and without ROS.

Only what happens is asserted, not when.
"""

import socket
import time

import numpy as np
import pytest
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import (
    NotReadyError,
)
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.driver import rm65_driver
from bathbot_scrub.rm65.settings import DriverSettings
from emulator_cell import AXIS, REGION, TARGET, Cell, running, segments, until
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph


@pytest.fixture
def cell():
    with running() as cell:
        yield cell


def test_the_whole_job(cell):
    driver = cell.driver
    touch = cell.approach()
    assert touch.force > 0.8  # filtered; what felt the skin is faster
    assert -0.009 < AXIS @ (TARGET[:3, 3] - touch.T_base_head[:3, 3]) < -0.001
    until(lambda: not driver.loop.moving)
    for segment in segments():
        driver.follow(segment)
    forces = []
    while not driver.snapshot().path_done:
        forces.append(driver.snapshot().force)
        assert cell.state() is State.CONTACT
        time.sleep(0.02)
    snapshot = driver.snapshot()
    assert snapshot.distance_along == pytest.approx(0.06, abs=1e-3)
    assert (snapshot.segment_index, snapshot.segments_queued, snapshot.reason) == (2, 0, "path done")
    assert cell.gap() == pytest.approx(-0.005, abs=2e-4)
    assert max(forces) < driver.limits.region(REGION).retract
    with pytest.raises(NotReadyError, match="CONTACT"):
        driver.home()
    driver.retract()
    until(lambda: cell.state() is State.FREE)
    until(lambda: cell.gap() > 0.085)
    driver.home()
    until(lambda: driver.snapshot().reason == "at home")
    until(lambda: np.abs(cell.emulator.truth().joints - np.radians(driver.settings.home_deg)).max() < 1e-3)
    assert driver._approach.came is None  # asked again, the arm must not go back towards the person
    assert cell.log == []


def test_a_lost_controller_is_a_fault_and_the_arm_stands(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    for segment in segments(speed=0.02):
        cell.driver.follow(segment)
    time.sleep(0.3)
    cell.emulator.order(Fault("dropped_tcp", duration=0.1))
    until(lambda: cell.state() is State.FAULT)
    time.sleep(0.3)
    at = cell.emulator.truth().joints
    time.sleep(0.3)
    assert_allclose(cell.emulator.truth().joints, at, atol=1e-5)
    until(lambda: cell.driver.snapshot().connected)
    cell.driver.resume()
    cell.driver.retract()
    until(lambda: cell.state() is State.FREE)
    assert any("lost the controller" in line for line in cell.log)


def test_what_waits_in_front_of_a_controller_that_stood_still_is_not_obeyed_later():
    """Frames that went out before the silence was noticed, and a stop behind them, wait in a lost socket."""
    with running(stale_after=0.3, wait_at_most=0.5, deaf_after=0.1, approach_speed=0.06) as cell:
        cell.approach()
        until(lambda: not cell.driver.loop.moving)
        for segment in segments(speed=0.08, depth=0.004):
            cell.driver.follow(segment)
        until(lambda: cell.driver.snapshot().distance_along > 0.015)
        cell.emulator.order(Fault("stalled"))
        until(lambda: cell.state() is State.FAULT)
        cell.driver.link.client.reconnect()
        stood = cell.emulator.truth().T_base_head[:3, 3]
        cell.emulator.order(Fault("none"))
        time.sleep(0.5)
        assert np.linalg.norm(cell.emulator.truth().T_base_head[:3, 3] - stood) < 2e-4


def test_a_server_that_is_no_controller_is_told_once():
    log = []
    with socket.create_server(("127.0.0.1", 0)) as silent:
        driver = rm65_driver(DriverSettings(port=silent.getsockname()[1], udp_port=0), log.append)
        until(lambda: any("is it an RM65 controller?" in line for line in log))
        time.sleep(2.5)
        assert sum("is it an RM65 controller?" in line for line in log) == 1
        assert len(log) <= 2
        assert not driver.snapshot().connected
        driver.close()


def test_another_arm_than_the_parameter_says_is_never_moved():
    cell = Cell(variant="6FB")
    try:
        until(lambda: cell.log)
        assert "set variant to 6F" in cell.log[0]
        with pytest.raises(NotReadyError):
            cell.approach()
    finally:
        cell.close()
