from types import SimpleNamespace

import numpy as np
import pytest
from bathbot_bringup.bathing.job import BathingJob
from bathbot_bringup.bathing.pace import Arrival, enough, pace, recent, too_slow
from bathbot_bringup.bathing.steps import Sighting, settled
from bathbot_bringup.errors import ProcessError, StepError
from bathbot_bringup.graph.stages import StageLog
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_localize.target.target import Target
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

ORDER = ["connect", "home", "select", "look", "approach", "scrub", "retract", "home"]


def sighting(x: float) -> Sighting:
    return Sighting(
        0.0,
        Target("Trunk_skin", 0.9, transform_from(translation=(x, 0.0, 0.0)), np.eye(6), (0.0, 0.0), 20.0, 9),
    )


class FakeBather:
    """Writes down what it is asked; fails where it is told to."""

    def __init__(self, fail_at="", error=None, said=""):
        self.calls, self.lengths, self._said = [], [], said
        self.pace = pace([], 0.0)
        self._fail_at, self._error = fail_at, error

    def __getattr__(self, name):
        def call(*arguments):
            self.calls.append(name)
            self.lengths += [value for value in arguments if isinstance(value, float)]
            if name == self._fail_at:
                raise self._error
            return SimpleNamespace(force=1.5, segments=3, length=0.4, error_msg=self._said)

        return call


def job(bather):
    return BathingJob(bather, StageLog(Console(quiet=True)), duration=10.0)


def test_the_steps_come_in_order():
    bather = FakeBather()
    job(bather).run()
    assert bather.calls == ORDER


def test_a_path_that_was_cut_short_is_told_though_the_job_is_done():
    bather, console = (
        FakeBather(said="the path ended after 85%, out of reach"),
        Console(record=True, width=200),
    )
    BathingJob(bather, StageLog(console), duration=10.0).run()
    assert "3 segments, 0.40 m of path; the path ended after 85%, out of reach" in console.export_text()
    assert bather.calls == ORDER


def test_the_duration_limits_the_length_of_the_path():
    bather = FakeBather()
    job(bather).run()
    assert bather.lengths == [pytest.approx(0.4)]


@pytest.mark.parametrize("step", ["connect", "select", "look", "approach", "scrub", "retract"])
def test_after_a_failed_step_the_arm_leaves_the_skin(step):
    bather = FakeBather(step, StepError(step, "no reason"))
    with pytest.raises(StepError, match=f"{step} failed: no reason"):
        job(bather).run()
    assert bather.calls == [*ORDER[: ORDER.index(step) + 1], "withdraw"]


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt(), ProcessError("camera", "died", "", "log")], ids=["Ctrl-C", "death"]
)
def test_ctrl_c_or_a_dead_node_stops_the_arm_where_it_is(error):
    bather = FakeBather("scrub", error)
    with pytest.raises(type(error)):
        job(bather).run()
    assert bather.calls[-1] == "stop_arm"


def test_an_arm_that_cannot_even_leave_does_not_hide_the_first_reason():
    bather = FakeBather("scrub", StepError("scrub", "the first reason"))
    bather.withdraw = lambda: (_ for _ in ()).throw(StepError("retract", "the second"))
    with pytest.raises(StepError, match="the first reason"):
        job(bather).run()


def test_how_long_each_step_took_is_kept():
    log = StageLog(Console(quiet=True))
    BathingJob(FakeBather(), log, 10.0).run()
    assert list(log.times) == ["connect", "look", "approach", "scrub", "retract", "home"]


@settings(deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), max_size=12), st.floats(0.0, 0.1))
def test_targets_are_settled_only_when_the_newest_agree(positions, spread):
    sightings = [sighting(x) for x in positions]
    agreed = settled(sightings, 5, spread)
    newest = np.array(positions[-5:])
    assert agreed == (len(newest) == 5 and bool(np.all(np.abs(newest - np.median(newest)) <= spread)))


def test_old_disagreement_does_not_matter():
    assert settled([sighting(x) for x in (5.0, -5.0, 0.1, 0.1, 0.1)], 3, 0.01)


def arrivals(rate, late, count=20):
    return [Arrival(number / rate, number / rate + late) for number in range(count)]


@given(rate=st.floats(0.2, 30.0), late=st.floats(0.0, 5.0))
def test_what_is_known_of_the_skin_is_as_old_as_its_delay_and_the_time_to_the_next(rate, late):
    measured = pace(arrivals(rate, late), 0.001)
    assert measured.rate == pytest.approx(rate)
    assert measured.oldest == pytest.approx(late + 1.0 / rate)
    assert bool(too_slow(measured, 1.5)) == (measured.oldest > 1.5)


def test_one_picture_that_comes_late_counts():
    steady = arrivals(5.0, 0.3)
    assert too_slow(pace([*steady[:10], *steady[18:]], 0.001), 1.5)
    assert not too_slow(pace(steady, 0.001), 1.5)


def test_a_machine_that_sees_nothing_is_too_slow():
    assert "0.0 times a second" in too_slow(pace(arrivals(1.0, 1.0, count=1), 0.001), 1.5)


def test_an_arm_off_its_beat_is_told_with_the_number():
    assert "commands come 31 ms off their beat; 20 ms are allowed" in too_slow(
        pace(arrivals(5.0, 0.3), 0.031), 1.5
    )


def test_a_slow_beginning_is_forgiven():
    slow, then = arrivals(0.5, 3.0, count=3), [Arrival(10.0 + k / 5, 10.3 + k / 5) for k in range(20)]
    assert too_slow(pace([*slow, *then], 0.001), 1.5)
    assert not too_slow(pace(recent([*slow, *then]), 0.001), 1.5)
    assert recent([]) == []


def test_three_seconds_are_enough_to_judge_by():
    assert not enough(arrivals(5.0, 0.3, count=15))
    assert enough(arrivals(5.0, 0.3, count=17))
