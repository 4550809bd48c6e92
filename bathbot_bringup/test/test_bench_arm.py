"""The arm's bench: how regular a stream is, and what is refused."""

import numpy as np
import pytest
from bathbot_bringup.bench.arm import arm_table
from bathbot_bringup.bench.arm_stream import PERIOD, regularity
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import StepError
from bathbot_bringup.sim.arm.trace import TraceData
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

START = 50.0  # [s]


def trace_of(gaps, pushed=1.0):
    """A trace with these gaps [s] between frames, of which a share of the steps pushed state."""
    frames = START + np.concatenate([[0.0], np.cumsum(gaps)])
    stamps = np.arange(START, frames[-1] + 0.005, 0.005)
    force = np.where(np.arange(len(stamps)) % 10 < 10 * pushed, 1.0, np.nan)
    empty = {name: np.zeros(0) for name in TraceData._fields}
    return TraceData(**empty | {"stamp": stamps, "pushed_force": force, "frame_stamp": frames})


@settings(deadline=None)
@given(late=st.lists(st.floats(0.0201, 0.5), max_size=20), count=st.integers(2, 300), seed=st.integers(0, 99))
def test_every_gap_above_two_periods_is_counted_once(late, count, seed):
    gaps = np.random.default_rng(seed).permutation([*([PERIOD] * count), *late])
    found = regularity(trace_of(gaps), 0, 0)
    assert found.stream_missed == len(late)
    assert found.frames == count + len(late) + 1
    assert found.longest_period_ms == pytest.approx(1e3 * max([PERIOD, *late]))


@settings(deadline=None)
@given(jitter=st.floats(0.0, 0.009), count=st.integers(50, 300))
def test_the_deviation_is_that_of_the_gaps(jitter, count):
    gaps = PERIOD + jitter * np.where(np.arange(count) % 2, 1.0, -1.0)
    assert regularity(trace_of(gaps), 0, 0).stream_period_p99_dev_ms == pytest.approx(1e3 * jitter, abs=1e-6)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_the_push_is_counted_by_the_controller_s_clock(share):
    found = regularity(trace_of(np.full(500, PERIOD), share), 3, 4)
    assert found.push_hz == pytest.approx(200.0 * share, rel=0.01)
    assert (found.protocol_errors, found.driver_missed) == (3, 4)


def test_no_stream_is_said_in_words():
    with pytest.raises(StepError, match="only 1 frames"):
        regularity(trace_of(np.zeros(0)), 0, 0)


def test_the_table_shows_what_was_measured():
    kinematics = {"ik_us_per_pose": 4.2, "ik_vs_eaik": 3.0, "ik_vs_pin": 30.0, "eaik_us_per_pose": 12.6,
                  "pin_us_per_pose": 126.0, "machine": {"cores": 2, "cpu": "x", "load": 0.1}}  # fmt: skip
    console = Console(width=120)
    with console.capture() as shown:
        console.print(arm_table(kinematics))
    assert "12.6 us" in shown.get()
    assert arm_table(kinematics).row_count == 3
    stream = regularity(trace_of(np.full(500, PERIOD)), 0, 0)._asdict()
    assert arm_table(kinematics | stream).row_count > 6


@pytest.mark.parametrize("seconds", ["-1", "5", "1e9", "nan"])
def test_times_that_cannot_be_watched_are_refused(seconds, capsys):
    assert run(["bench", "arm", "--seconds", seconds]) == 2
    assert "seconds must be 0 or lie in 20..1100" in capsys.readouterr().err
