"""The period of the control loop."""

import pytest
from bathbot_scrub.rm65.period import Beat, PeriodStatistics


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
    import time

    beat, begin = Beat(0.002), time.monotonic()
    for _ in range(50):
        beat.wait()
    assert time.monotonic() - begin >= 50 * 0.002 - 1e-3
