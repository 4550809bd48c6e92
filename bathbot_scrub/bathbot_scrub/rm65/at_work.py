"""Whether the arm has anything to do on the skin, and for how long it has not. Pure; time is an argument."""

from bathbot_scrub.rm65.force_guard import ForceGuard
from bathbot_scrub.rm65.guard_states import State
from bathbot_scrub.rm65.vital_signs import Activity


class AtWork:
    """Times the arm's standing still on the skin."""

    def __init__(self) -> None:
        """Begin off the skin."""
        self._idle_since: float | None = None

    def judge(self, guard: ForceGuard, path_open: bool, now: float) -> Activity:
        """What the arm does at `now` [s]; `path_open`: a path was begun, and more of it must come."""
        idle = guard.touching and not guard.moving and guard.state in (State.CONTACT, State.HOLD)
        if not idle:
            self._idle_since = None
            return Activity(False, 0.0, path_open)
        self._idle_since = now if self._idle_since is None else self._idle_since
        starved = path_open and guard.state is State.CONTACT and not guard.waiting
        return Activity(starved, now - self._idle_since, path_open)
