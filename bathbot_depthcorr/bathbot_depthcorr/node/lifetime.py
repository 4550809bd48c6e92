"""What a node holds between two of its transitions, and the order in which it lets go of it."""

from collections.abc import Callable
from contextlib import ExitStack
from enum import IntEnum


class Rank(IntEnum):
    """Kinds of things held, in the order of their ending."""

    SOURCE = 0
    """Calls the node: a timer, a subscription."""
    WORKER = 1
    """Works beside the executor: a thread, a device, a file."""
    OUTLET = 2
    """Is used by both: a publisher, a client, a server."""


class Lifetime:
    """Closes what it was given: sources first, outlets last, within a rank the newest first.

    So nobody hands work to a worker that has ended, and none sends by a publisher that is gone.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self._stacks = {rank: ExitStack() for rank in Rank}

    def keep(self, rank: Rank, close: Callable[[], object]) -> None:
        """Remember how to close something."""
        self._stacks[rank].callback(close)

    def close_sources(self) -> None:
        """Close what calls the node; the rest stays usable."""
        self._stacks[Rank.SOURCE].close()

    def close(self) -> None:
        """Close everything, even where closing one thing fails; the last failure is raised again."""
        with ExitStack() as all_stacks:
            for rank in reversed(Rank):
                all_stacks.callback(self._stacks[rank].close)
