"""Somebody moves into a way that was free when it was planned; driver and arm live in virtual time."""

import time

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import AXIS, TARGET, VirtualCell, ready_deg
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import CanceledError, NotReadyError
from bathbot_scrub.arm.states import State

READY = {"home_deg": ready_deg(0.15), "standoff": 0.06, "approach_speed": 0.05}
IN_THE_WAY = "the person has moved into the way"


def cell(**settings):
    cell = VirtualCell("Trunk_skin", **READY | settings)
    see(cell)
    return cell


def see(cell):
    cell.driver.surroundings.see(cell.person.cloud(cell.clock()), cell.clock())


def test_who_leans_into_the_way_is_seen_and_the_arm_stands_and_says_so():
    cell = VirtualCell("Face_skin", **READY | {"home_deg": ready_deg(0.22)})  # not where the person leans to
    cell.look(0.2, 0.2)
    cell.wait(0.3)
    cell.lean(0.12, 0.3, after=0.4)
    with pytest.raises(CanceledError, match=IN_THE_WAY):
        cell.approach()
    cell.wait(1.0)
    assert cell.state() is State.HOLD
    assert IN_THE_WAY in cell.driver.snapshot().reason
    assert not cell.moving()
    assert cell.peak() == 0.0


def test_a_paused_motion_does_not_go_on_into_somebody():
    cell_ = cell()
    cell_.after(0.9, cell_.driver.pause)
    said = []

    def resume():
        cell_.lean(cell_.gap() - 0.003, 10.0)
        cell_.wait(0.1)
        see(cell_)
        try:
            cell_.driver.resume()
        except NotReadyError as error:
            said.append(str(error))
        stood.append(cell_.controller.dynamics.joints)
        cell_.wait(0.5)
        stood.append(cell_.controller.dynamics.joints)
        assert cell_.state() is State.HOLD
        cell_.driver.stop()

    stood = []
    cell_.clock.at(cell_.clock() + 1.4, resume)
    with pytest.raises(CanceledError):
        cell_.approach()
    assert IN_THE_WAY in said[0]
    assert np.abs(stood[1] - stood[0]).max() < 1e-3
    assert cell_.peak() == 0.0


def test_a_motion_that_waited_does_not_go_on_into_somebody():
    cell_ = cell()
    cell_.clock.at(cell_.clock() + 0.9, lambda: cell_.order(Fault("lost_udp", duration=0.15)))

    def come():
        cell_.lean(cell_.gap() - 0.01, 10.0)
        cell_.after(0.02, lambda: see(cell_))
        cell_.after(0.07, cell_.driver.watch.look)

    cell_.clock.at(cell_.clock() + 1.1, come)
    with pytest.raises(CanceledError, match=IN_THE_WAY):
        cell_.approach()
    assert cell_.peak() == 0.0


def looked_at(cell_, until):
    """As the driver's thread looks, while no cloud comes."""
    if cell_.clock() < until:
        cell_.driver.watch.look()
        cell_.after(0.05, lambda: looked_at(cell_, until))


@pytest.mark.parametrize("waits", [False, True], ids=["under way", "waiting for the controller"])
def test_a_camera_gone_blind_ends_the_way_to_the_person(waits):
    cell_ = cell(body_max_age=1.2)
    if waits:
        cell_.after(0.9, lambda: cell_.order(Fault("lost_udp", duration=0.15)))
    looked_at(cell_, cell_.clock() + 5.0)
    with pytest.raises(CanceledError, match=r"the body was last seen 1\.\d s ago"):
        cell_.approach()
    stood = cell_.controller.dynamics.joints
    cell_.wait(2.0)
    assert cell_.state() is State.HOLD
    assert np.abs(cell_.controller.dynamics.joints - stood).max() < 0.02  # what braking took
    assert cell_.peak() == 0.0


def test_an_empty_cloud_ends_the_way_to_the_person():
    cell_ = cell()
    cell_.after(0.9, lambda: cell_.driver.surroundings.see(np.empty((0, 3)), cell_.clock()))
    looked_at(cell_, cell_.clock() + 5.0)
    with pytest.raises(CanceledError, match="the body cloud is empty"):
        cell_.approach()
    assert cell_.peak() == 0.0


def test_an_old_cloud_does_not_keep_the_arm_from_home():
    cell_ = cell(body_max_age=1.0, home_deg=ready_deg(0.2))
    cell_.after(0.6, cell_.driver.stop)
    with pytest.raises(CanceledError):
        cell_.approach()
    cell_.wait(2.0)
    looked_at(cell_, cell_.clock() + 5.0)
    cell_.driver.home()
    cell_.clock.until(lambda: cell_.state() is State.FREE, 10.0)
    assert cell_.driver.snapshot().reason == "at home"


def test_breathing_and_a_cloud_that_is_never_the_same_twice_stop_nothing():
    rng = np.random.default_rng(3)
    cell_ = cell()

    def noisy():
        cloud = cell_.person.cloud(cell_.clock())
        cell_.driver.surroundings.see(cloud + rng.normal(0.0, 0.003, cloud.shape), cell_.clock())
        cell_.driver.watch.look()
        cell_.after(0.2, noisy)

    noisy()
    cell_.approach()
    see(cell_)
    cell_.scrub()
    cell_.wait(3.0)
    assert cell_.state() is State.CONTACT
    cell_.driver.retract()
    cell_.wait(1.0)
    cell_.driver.home()
    cell_.clock.until(lambda: cell_.state() is State.FREE, 30.0)
    assert cell_.driver.snapshot().reason == "at home"


def test_somebody_beside_a_link_stops_the_scrubbing():
    cell_ = cell()
    cell_.approach()
    see(cell_)
    cell_.scrub()
    cell_.wait(1.0)
    frames = cell_.driver.arm.link_frames(cell_.controller.dynamics.joints)
    cloud = cell_.person.cloud(cell_.clock())
    wrist = frames[4, :3, 3] + 0.02 * np.cross(AXIS, TARGET[:3, 1])
    beside = (
        wrist + np.linspace(-0.06, 0.06, 13)[:, None] * TARGET[:3, 1]
    )  # on both sides: one is come nearer
    cell_.driver.surroundings.see(np.concatenate([beside, cloud]), cell_.clock())
    cell_.driver.watch.look()
    assert IN_THE_WAY in cell_.driver.snapshot().reason
    assert cell_.state() is State.HOLD


def test_looking_holds_the_loops_lock_for_no_time_that_matters():
    cell_ = cell()
    cell_.approach()
    see(cell_)
    cell_.scrub()
    cell_.wait(0.5)
    lock, held = cell_.driver.loop.lock, []

    class Timed:
        def __enter__(self):
            lock.__enter__()
            self.begin = time.perf_counter()

        def __exit__(self, *error):
            held.append(time.perf_counter() - self.begin)
            return lock.__exit__(*error)

    cell_.driver.loop.lock = Timed()
    for _ in range(20):
        see(cell_)
        cell_.driver.watch.look()
    cell_.driver.loop.lock = lock
    assert len(held) == 20
    assert np.median(held) < 1e-3  # microseconds; the machine may be busy
