"""The arm driver against the emulated controller over TCP and UDP, with exact surfaces and without ROS.

Only what happens is asserted, not when.
"""

import socket
import threading
import time

import numpy as np
import pytest
from bathbot_bringup.sim.faults.faults import Fault
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
from bathbot_scrub.rm65.arm.limits import HOME_DEG
from bathbot_scrub.rm65.driver import rm65_driver
from bathbot_scrub.rm65.motion.approach import Request
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


def test_a_starved_path_waits_in_contact_and_goes_on(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    first, second, third = segments()
    cell.driver.follow(first)
    waits = f"waits for segments: segment 1 of path {first.path_id} has not come"
    until(lambda: cell.driver.snapshot().reason == waits)
    assert cell.state() is State.CONTACT
    with pytest.raises(NotReadyError, match="in order"):
        cell.driver.follow(third)
    assert "segment 2 was refused" in cell.driver.snapshot().reason
    cell.driver.follow(second)
    cell.driver.follow(third)
    until(lambda: cell.driver.snapshot().path_done)


def test_stop_stops_and_forgets_pause_stops_and_resumes(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    for segment in segments(speed=0.02):
        cell.driver.follow(segment)
    until(lambda: cell.driver.snapshot().distance_along > 0.005)
    cell.driver.pause()
    until(lambda: not cell.driver.loop.moving)
    assert (cell.state(), cell.driver.snapshot().reason) == (State.HOLD, "paused")
    at = cell.driver.snapshot().distance_along
    time.sleep(0.2)
    assert cell.driver.snapshot().distance_along == at
    cell.driver.resume()
    until(lambda: cell.driver.snapshot().distance_along > at + 0.005)
    cell.driver.stop()
    until(lambda: not cell.driver.loop.moving)
    assert cell.state() is State.HOLD
    for refused in (cell.driver.resume, cell.driver.home, lambda: cell.driver.follow(segments()[0])):
        with pytest.raises(NotReadyError):
            refused()
    cell.driver.retract()
    until(lambda: cell.state() is State.FREE)


def test_a_body_that_moves_into_the_brush_is_left_along_the_normal(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    cell.wall.shift = 0.006  # 6 mm nearer at once: the bristles are pressed flat, and more
    until(lambda: cell.state() is State.HOLD or cell.state() is State.FAULT)
    assert "retracted: force" in cell.driver.snapshot().reason
    until(lambda: cell.gap() > 0.05)
    offset = cell.emulator.truth().T_base_head[:3, 3] - TARGET[:3, 3]
    assert np.linalg.norm(np.cross(offset, AXIS)) < 2e-3
    with pytest.raises(NotReadyError, match="arm/resume"):
        cell.driver.home()
    cell.driver.resume()
    cell.driver.home()
    until(lambda: cell.driver.snapshot().reason == "at home")


def test_no_skin_where_it_should_be(cell):
    cell.wall.shift = -0.05
    with pytest.raises(NoContactError, match="has the person moved"):
        cell.approach()
    assert cell.state() is State.HOLD
    with pytest.raises(NotReadyError, match="arm/retract first"):
        cell.approach()
    cell.driver.retract()
    until(lambda: cell.state() is State.FREE)


def test_skin_nearer_than_believed_is_felt_all_the_same(cell):
    cell.wall.shift = 0.02
    cell.approach()
    assert cell.emulator.truth().contact.compression < 0.010
    assert cell.emulator.truth().contact.indentation == 0.0


def test_something_in_the_way_to_the_standoff_sends_it_back():
    with running(home_deg=HOME_DEG) as cell:
        cell.wall.shift = 0.15
        with pytest.raises(ForceLimitError, match="force"):
            cell.approach()
        until(lambda: np.linalg.norm(cell.emulator.truth().contact.force) == 0.0)
        assert cell.state() in (State.HOLD, State.FAULT)


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
    before = cell.emulator.truth().joints
    with pytest.raises(error) as caught:
        cell.approach(**request_)
    assert "\n" not in str(caught.value)
    time.sleep(0.1)
    assert_allclose(cell.emulator.truth().joints, before)
    assert cell.state() is State.FREE


def test_a_canceled_approach_stands_still(cell):
    canceled = threading.Event()
    threading.Timer(0.5, canceled.set).start()
    with pytest.raises(CanceledError):
        cell.driver.approach(Request(TARGET, REGION), canceled.is_set)
    until(lambda: not cell.driver.loop.moving)
    until(lambda: np.abs(cell.emulator.truth().joints - cell.driver.loop.where()).max() < 1e-3)
    at = cell.emulator.truth().joints
    time.sleep(0.3)
    assert_allclose(cell.emulator.truth().joints, at, atol=2e-3)


def test_segments_far_away_or_beyond_reach_are_refused(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    first = segments()[0]
    away = first.T_base_heads.copy()
    away[:, 2, 3] += 0.5
    for poses in (away, first.T_base_heads * np.nan, np.zeros((0, 4, 4))):
        with pytest.raises((UnreachableError, InvalidPoseError, NotReadyError)):
            cell.driver.follow(first._replace(T_base_heads=poses))
    assert cell.state() is State.CONTACT
    cell.driver.follow(first)


def test_a_path_that_begins_elsewhere_is_reached_over_the_skin(cell):
    cell.approach()
    until(lambda: not cell.driver.loop.moving)
    aside = segments()[2]._replace(index=0)
    cell.driver.follow(aside)
    highest = 0.0
    while not cell.driver.snapshot().path_done:
        assert cell.state() is State.CONTACT
        highest = max(highest, cell.gap())
        time.sleep(0.01)
    assert highest == pytest.approx(0.03 - 0.002, abs=0.004)


def test_a_full_queue_refuses():
    with running(queue_length=2) as cell:
        cell.approach()
        until(lambda: not cell.driver.loop.moving)
        pieces = segments(count=4, speed=0.005)
        cell.driver.follow(pieces[0])
        cell.driver.follow(pieces[1])
        with pytest.raises(NotReadyError, match="2 segments wait"):
            cell.driver.follow(pieces[2])


def test_silence_of_the_push_stops_the_arm_and_resume_clears_it():
    with running(stale_after=0.5) as cell:
        cell.approach()
        until(lambda: not cell.driver.loop.moving)
        cell.driver.link.client.demand({"command": "set_realtime_push", "enable": False}, "state")
        until(lambda: cell.state() is State.FAULT)
        assert "no state from the controller" in cell.driver.snapshot().reason
        with pytest.raises(NotReadyError, match="cannot resume"):
            cell.driver.resume()
        cell.driver.link.client.demand({"command": "set_realtime_push", "enable": True}, "state")
        until(lambda: cell.driver.snapshot().connected)
        cell.driver.resume()
        cell.driver.retract()
        until(lambda: cell.state() is State.FREE)


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
