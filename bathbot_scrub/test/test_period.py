"""The period of the control loop."""

import time

import pytest
from bathbot_scrub.rm65.timing.beat import Beat
from bathbot_scrub.rm65.timing.stream_statistics import PeriodStatistics


def test_period_statistics_tell_the_deviation():
    statistics = PeriodStatistics(0.01)
    for now in (0.0, 0.01, 0.02, 0.032, 0.06):
        statistics.tick(now)
    assert statistics.p99() == pytest.approx(0.018, abs=5e-4)
    assert statistics.missed == 1
    statistics.pause()
    statistics.tick(100.0)
    assert statistics.missed == 1


def test_the_beat_does_not_drift():
    beat, begin = Beat(0.002), time.monotonic()
    for _ in range(50):
        while not beat.passed():
            time.sleep(beat.left())
    assert time.monotonic() - begin >= 50 * 0.002 - 1e-3


def test_a_beat_that_is_brought_forward_falls_due_at_once_and_the_others_follow_from_there():
    beat = Beat(60.0)
    assert beat.left() > 50.0
    assert not beat.passed()
    beat.bring_forward(time.monotonic() - 1.0)
    assert beat.left() == 0.0
    assert beat.passed()
    assert 50.0 < beat.left() <= 60.0
    beat.bring_forward(time.monotonic() + 120.0)  # never later than it was
    assert beat.left() <= 60.0
