"""Hears how quickly this machine sees, while a region is looked for."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bathbot_depthcorr.ros.serialized_image import stamp_of
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from sensor_msgs.msg import PointCloud2

from bathbot_bringup.bathing.pace import Arrival, Pace, enough, pace, recent, too_slow
from bathbot_bringup.graph.client_node import GraphClient

_PATIENCE = ScrubPlannerSettings().lost_after  # [s]
_ALLOWED = 0.5 * _PATIENCE  # [s] while the arm stands: the machine will be busier
_LONGEST = 20.0  # [s] within which it has kept up for some seconds, or the machine is too slow


class PaceWatch:
    """Times what comes of pictures by the clock of the client's node.

    Attributes:
        pace: What was measured last; None before.
    """

    def __init__(self, client: GraphClient) -> None:
        """Listen to nothing yet."""
        self.pace: Pace | None = None
        self._client = client
        self._surfaces: list[Arrival] = []  # of the region
        self._looks: list[Arrival] = []  # for targets, whether any was found or not

    def looked(self, taken: float) -> None:
        """The picture of the time `taken` [s] was searched for targets."""
        self._looks.append(self._arrival(taken))

    @contextmanager
    def hearing(self) -> Iterator[None]:
        """Hear surfaces during the block."""
        self._surfaces.clear()
        self._looks.clear()
        node, hear = self._client.node, lambda raw: self._surfaces.append(self._arrival(stamp_of(raw)))
        surfaces = node.create_subscription(PointCloud2, "surface", hear, 5, raw=True)
        try:
            yield
        finally:
            node.destroy_subscription(surfaces)

    def wait(self, off_beat: Callable[[], float]) -> None:
        """Wait until this machine has kept up for some seconds, or far too long; see `trouble`."""
        self._client.spin_until(
            lambda: enough(self._surfaces) and not self.trouble(True, off_beat()), _LONGEST
        )

    def trouble(self, found: bool, off_beat: float) -> str:
        """Why this machine is too slow, with the numbers; empty when it is not.

        Args:
            found: Whether the region was; without it there is no surface, only the search for it.
            off_beat: 99th percentile of how far the arm's commands come off their beat [s].
        """
        self.pace = pace(recent(self._surfaces if found else self._looks), off_beat)
        slow = too_slow(self.pace, _ALLOWED if found else _PATIENCE)
        return slow and f"this machine is too slow, or too busy: {slow}"

    def _arrival(self, taken: float) -> Arrival:
        return Arrival(taken, 1e-9 * self._client.node.get_clock().now().nanoseconds)
