"""The cell in virtual time: what is due happens in order, alike from one seed, and the driver lives in it."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.virtual.person import Lean, Person, Sway
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import TARGET, VirtualCell, ready_deg
from bathbot_bringup.evaluation.safety.virtual.virtual_clock import VirtualClock
from bathbot_bringup.evaluation.safety.virtual.wire import Delay, Wire
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import NoContactError, NotReadyError
from bathbot_scrub.arm.states import State

READY = {"home_deg": ready_deg(0.08), "standoff": 0.03, "approach_speed": 0.05}


def test_what_is_due_happens_in_the_order_of_its_time_and_then_of_its_order():
    clock, happened = VirtualClock(), []
    begin = clock()
    for name, when in (("late", 0.3), ("first", 0.1), ("second", 0.1), ("never", 9.0)):
        clock.at(begin + when, lambda name=name: happened.append((name, round(clock() - begin, 6))))
    clock.sleep(1.0)
    assert happened == [("first", 0.1), ("second", 0.1), ("late", 0.3)]
    assert clock() == begin + 1.0


def test_who_waits_for_news_lets_time_pass_until_they_come():
    clock, seen = VirtualClock(), []
    news = clock.condition()
    begin = clock()
    clock.at(begin + 0.2, lambda: seen.append("it"))
    with news:
        assert news.wait_for(lambda: seen, 1.0)
        assert clock() == begin + 0.2
        assert not news.wait_for(lambda: not seen, 0.5)
        assert clock() == pytest.approx(begin + 0.7)


def test_nothing_overtakes_on_a_wire():
    clock, arrived = VirtualClock(), []
    wire = Wire(clock, np.random.default_rng(0), Delay(0.001, 0.02))
    for number in range(50):
        clock.at(clock() + 0.002 * number, lambda n=number: wire.send(lambda: arrived.append((n, clock()))))
    begin = clock()
    clock.sleep(1.0)
    assert [number for number, _ in arrived] == list(range(50))
    late = [when - begin - 0.002 * number for number, when in arrived]
    assert min(late) >= 0.001
    assert max(late) <= 0.021


def test_a_person_leans_by_a_distance_at_a_speed_and_sways():
    person = Person(TARGET, "Trunk_skin")
    person.lean(Lean(10.0, 0.06, 0.1))
    assert [person.shift(t) for t in (9.0, 10.3, 20.0)] == pytest.approx([0.0, 0.03, 0.06])
    behind = TARGET[:3, 3] - 0.2 * TARGET[:3, 2]
    distances, _, part = person.distance(behind[None], TARGET[None, :3, 2], 20.0)
    assert distances[0] == pytest.approx(0.14)
    assert part == "Trunk_skin"
    assert ((person.cloud(20.0) - behind) @ TARGET[:3, 2]).max() == pytest.approx(0.14)
    assert Person(TARGET, "Trunk_skin", (Sway(0.004, 0.25),)).shift(1.0) == pytest.approx(0.004)


@pytest.fixture(scope="module")
def scrubbing():
    cell = VirtualCell("Trunk_skin", seed=2, **READY)
    begin = cell.clock()
    cell.approach()
    touched = cell.clock()
    cell.scrub()
    cell.wait(2.0)
    return cell, touched - begin


def test_the_driver_approaches_and_scrubs_as_beside_an_arm(scrubbing):
    cell, took = scrubbing
    assert cell.state() is State.CONTACT
    assert 1.5 < took < 6.0  # of virtual time: zeroing twice, the way there, 30 mm at 50 mm/s
    assert cell.region.comfort[0] < cell.force() < cell.region.comfort[1]
    assert cell.driver.snapshot().distance_along > 0.02
    assert cell.log == []


def test_the_same_seed_is_the_same_life_and_another_is_another(scrubbing):
    cell, _ = scrubbing
    lives = {}
    for seed in (2, 3):
        other = VirtualCell("Trunk_skin", seed=seed, **READY)
        other.approach()
        lives[seed] = other.trace.data()
    mine = cell.trace.data()
    same = len(lives[2].stamp)
    assert np.array_equal(mine.joints[:same], lives[2].joints)
    assert np.array_equal(mine.pushed_force[:same], lives[2].pushed_force)
    assert not np.array_equal(lives[3].pushed_force[:400], lives[2].pushed_force[:400])


def test_a_push_makes_the_driver_leave():
    cell = VirtualCell("Trunk_skin", seed=1, **READY)
    cell.approach()
    cell.wait(0.3)
    cell.lean(0.03, 0.1)
    cell.wait(1.0)
    assert cell.state() in (State.HOLD, State.FAULT)
    assert 1.0 < cell.peak() < cell.region.hard_stop
    assert cell.gap() > 0.05


def test_without_a_body_the_search_ends_in_words():
    cell = VirtualCell("Trunk_skin", **READY)
    cell.lean(-0.05, 10.0)
    with pytest.raises(NoContactError):
        cell.approach()


def test_what_fails_in_the_controller_fails_here_too():
    cell = VirtualCell("Trunk_skin", **READY)
    cell.approach()
    cell.order(Fault("lost_udp", duration=2.0))
    cell.wait(1.0)
    assert cell.state() is State.FAULT
    with pytest.raises(NotReadyError):
        cell.driver.resume()
    cell.wait(1.5)
    cell.driver.resume()
    assert cell.state() is State.HOLD


def test_a_connection_that_is_cut_comes_back():
    cell = VirtualCell("Trunk_skin", **READY)
    cell.approach()
    cell.order(Fault("dropped_tcp", duration=0.3))
    cell.wait(0.2)
    assert (cell.state(), cell.driver.snapshot().connected) == (State.FAULT, False)
    cell.wait(1.0)
    assert cell.driver.snapshot().connected


def test_what_is_to_happen_at_a_place_happens_there():
    cell, gaps = VirtualCell("Trunk_skin", home_deg=ready_deg(0.15)), []
    cell.when(lambda: cell.gap() < 0.1, lambda: gaps.append(cell.gap()))
    cell.approach()
    assert gaps == [pytest.approx(0.1, abs=0.005)]


def test_what_is_ordered_for_later_happens_while_the_driver_is_on_its_way():
    cell = VirtualCell("Trunk_skin", home_deg=ready_deg(0.15))
    cell.after(0.8, cell.driver.stop)
    with pytest.raises(Exception, match="stopped"):
        cell.approach()
    assert cell.state() is State.HOLD
