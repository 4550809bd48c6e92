"""When something that is made at a rate is due again, by the stamps of the pictures it is made from."""

_EARLY = 0.95  # of a period: a picture a little early counts as in time


class Schedule:
    """Knows for each name when its next is due; several threads may use it."""

    def __init__(self, **rates: float) -> None:
        """Each name has a rate [Hz]; the first of each is due at once."""
        self._periods = {name: 1.0 / rate for name, rate in rates.items()}
        self._next: dict[str, float] = {}

    def due(self, name: str, stamp: float) -> bool:
        """Whether the picture taken at `stamp` [s] is to be used; the next is due a period later.

        After a jump back in time (a bag played again) it is due at once.
        """
        period = self._periods[name]
        due = not 0.0 < self._next.get(name, 0.0) - stamp <= period
        if due:
            self._next[name] = stamp + _EARLY * period
        return due

    def repeat(self, name: str) -> None:
        """Make the next due at once: the last one failed."""
        self._next.pop(name, None)
