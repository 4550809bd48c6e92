"""A node lets go of what it holds in an order in which nobody misses anything."""

import pytest
from bathbot_depthcorr.node.lifetime import Lifetime, Rank


def holding(*things: tuple[str, Rank]) -> tuple[Lifetime, list[str]]:
    lifetime, closed = Lifetime(), []
    for name, rank in things:
        lifetime.keep(rank, lambda name=name: closed.append(name))
    return lifetime, closed


def test_sources_end_first_and_outlets_last_whatever_was_made_when():
    lifetime, closed = holding(
        ("publisher", Rank.OUTLET), ("worker", Rank.WORKER), ("timer", Rank.SOURCE),
        ("late publisher", Rank.OUTLET), ("late worker", Rank.WORKER),
    )  # fmt: skip
    lifetime.close()
    assert closed == ["timer", "late worker", "worker", "late publisher", "publisher"]


def test_sources_may_end_alone_and_nothing_ends_twice():
    lifetime, closed = holding(("worker", Rank.WORKER), ("timer", Rank.SOURCE))
    lifetime.close_sources()
    assert closed == ["timer"]
    lifetime.close()
    lifetime.close()
    assert closed == ["timer", "worker"]


def test_one_that_cannot_close_keeps_none_of_the_others_open():
    lifetime, closed = holding(("publisher", Rank.OUTLET), ("first", Rank.WORKER))

    def fail() -> None:
        raise OSError("stuck")

    lifetime.keep(Rank.WORKER, fail)
    with pytest.raises(OSError, match="stuck"):
        lifetime.close()
    assert closed == ["first", "publisher"]


def test_it_can_be_filled_again():
    lifetime, closed = holding(("timer", Rank.SOURCE))
    lifetime.close()
    lifetime.keep(Rank.SOURCE, lambda: closed.append("again"))
    lifetime.close()
    assert closed == ["timer", "again"]
