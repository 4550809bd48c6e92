"""Which faults last at the moment, and what has begun or ended."""

from collections import deque
from typing import NamedTuple

from bathbot_bringup.sim.faults.faults import Fault
from bathbot_bringup.sim.faults.kinds import KINDS, NONE
from bathbot_bringup.sim.faults.lasting_fault import LastingFault, Place

BEGIN, END = "begin", "end"


class FaultEvent(NamedTuple):
    """A fault began or ended."""

    stamp: float  # [s] of the clock given to `update`
    kind: str
    phase: str  # BEGIN or END


class _Waiting(NamedTuple):
    fault: Fault
    begin: float
    end: float


class FaultSchedule:
    """Faults in time.

    `order` may be called from any thread. One thread calls `update`; what it found is read by all, for a
    dictionary that is replaced as a whole can be read at any moment. The faults of one place are let act by
    one thread.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self._ordered: deque[_Waiting] = deque()
        self._waiting: list[_Waiting] = []
        self._lasting: list[_Waiting] = []
        self._acting: dict[Place, dict[str, LastingFault]] = {place: {} for place in Place}
        self._kinds: frozenset[str] = frozenset()

    def order(self, fault: Fault, now: float) -> None:
        """Take a fault, ordered at `now` [s]."""
        begin = now + fault.after
        self._ordered.append(_Waiting(fault, begin, begin + fault.duration))

    def update(self, now: float) -> list[FaultEvent]:
        """Begin and end what is due at `now` [s]."""
        while self._ordered:
            self._waiting.append(self._ordered.popleft())
        if not self._waiting and not self._lasting:
            return []
        events = []
        for entry in [entry for entry in self._lasting if entry.end <= now]:
            self._lasting.remove(entry)
            events.append(FaultEvent(now, entry.fault.kind, END))
        for entry in [entry for entry in self._waiting if entry.begin <= now]:
            if entry.fault.kind == NONE:
                events += [FaultEvent(now, other.fault.kind, END) for other in self._lasting]
                events.append(FaultEvent(now, NONE, BEGIN))
                self._waiting, self._lasting = [], []
                break  # what was ordered behind it in the same step waits no more, either
            self._waiting.remove(entry)
            self._lasting.append(entry)
            events.append(FaultEvent(now, entry.fault.kind, BEGIN))
        self._let_act({entry.fault.kind: entry.fault.value for entry in self._lasting})
        return events

    def _let_act(self, values: dict[str, float]) -> None:
        """Give each place its faults of the kinds that last; one that goes on keeps its memory."""
        before, acting = self._acting, {place: {} for place in Place}
        for name in (name for name in KINDS if name in values):
            for place, act in KINDS[name].acts.items():
                known = before[place].get(name)
                memory = {} if known is None else known.memory
                acting[place][name] = LastingFault(act, values[name], memory)
        self._acting, self._kinds = acting, frozenset(values)

    def at(self, place: Place) -> list[LastingFault]:
        """The faults that last in a place, in the order of the table; of two of one kind the newest."""
        return list(self._acting[place].values())

    def __contains__(self, kind: str) -> bool:
        """Whether a fault of a kind lasts."""
        return kind in self._kinds
