"""How regular the stream of commands is, and how soon it answers."""

import pytest
from bathbot_scrub.rm65.timing.stream_statistics import PeriodStatistics, ReactionStatistics


def test_period_statistics_tell_the_deviation():
    statistics = PeriodStatistics(0.01)
    for now in (0.0, 0.01, 0.02, 0.032, 0.06):
        statistics.tick(now)
    assert statistics.p99() == pytest.approx(0.018, abs=5e-4)
    assert statistics.missed == 1
    statistics.pause()
    statistics.tick(100.0)
    assert statistics.missed == 1


def test_reactions_are_counted():
    reactions = ReactionStatistics()
    assert (reactions.p99(), reactions.count) == (0.0, 0)
    for seconds in (0.006, 0.007, 0.012):
        reactions.add(seconds)
    assert (reactions.longest, reactions.count) == (0.012, 3)
    assert 0.007 < reactions.p99() <= 0.012
