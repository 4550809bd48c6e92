"""When commands went out: how regular they are, and how soon they answer to force."""

from bathbot_scrub.rm65.reaction import PeriodStatistics, ReactionStatistics


class CommandLog:
    """Accounts for the stream of commands. One thread writes, others read the statistics."""

    def __init__(self, period: float) -> None:
        """Nothing was sent yet; `period` [s] is wanted."""
        self.statistics, self.reactions = PeriodStatistics(period), ReactionStatistics()
        self.last = 0.0  # [s] when the last command went out
        self._over_since: float | None = None  # [s] stamp of the sample that is being answered

    def answer(self, over_since: float | None) -> None:
        """The next command answers to a force whose first sample came at `over_since` [s]."""
        self._over_since = over_since

    def sent(self, now: float) -> None:
        """A command went out now [s]."""
        if self._over_since is not None:
            self.reactions.add(now - self._over_since)
            self.statistics.pause()  # this one came early, on purpose
            self._over_since = None
        self.last = now
        self.statistics.tick(now)

    def pause(self) -> None:
        """The stream rests."""
        self.statistics.pause()
