"""The client that has a region looked for: it selects the region and gathers contact targets."""

from collections.abc import Iterator
from contextlib import contextmanager

from bathbot_depthcorr.ros.messages import stamp_seconds
from bathbot_depthcorr.ros.serialized_image import stamp_of
from bathbot_localize.messages import targets_from_contact
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2

from bathbot_bringup.bathing import steps
from bathbot_bringup.bathing.pace import Arrival, Pace, enough, pace, too_slow
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.msg import ArmState, ContactTargets
from bathbot_msgs.srv import SelectRegion

_AGREEING, _SPREAD = 5, 0.01  # sightings, [m]
_PATIENCE = ScrubPlannerSettings().lost_after  # [s]
_ALLOWED = 0.5 * _PATIENCE  # [s] while the arm stands: the machine will be busier
_LONGEST = 15.0  # [s] within which enough surfaces come, or the machine is too slow


class RegionFinder:
    """Looks for one region; what does not succeed raises `StepError` with a reason.

    Attributes:
        arm: What the driver said last.
        pace: How quickly this machine saw and moved while it was looked; None before.
    """

    def __init__(self, client: GraphClient, region: str) -> None:
        """Listen to targets, to the arm, and to what the nodes complain about.

        Args:
            client: Has joined the graph.
            region: Full name, such as `Trunk_skin`.
        """
        self._client, self._region = client, region
        self._sightings: list[Sighting] = []
        self._complaints: dict[str, str] = {}
        self._regions_seen: set[str] = set()
        self.arm = ArmState()
        self.pace: Pace | None = None
        self._surfaces: list[Arrival] = []  # of the region
        self._looks: list[Arrival] = []  # for targets, whether any was found or not
        client.node.create_subscription(ArmState, "arm_state", self._on_arm, 10)
        client.service(SelectRegion, "select_region")
        client.node.create_subscription(ContactTargets, "contact_targets", self._on_targets, 10)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 50)

    def select(self) -> None:
        """Tell the localiser which region is wanted."""
        step = steps.SELECT
        request = SelectRegion.Request(region=self._region)
        response = self._client.call(step.name, SelectRegion, "select_region", request, step.timeout, tries=3)
        if response.error_code != SelectRegion.Response.NONE:
            raise StepError(step.name, response.error_msg)

    def look(self) -> Sighting:
        """Gather targets while the arm is out of the way, until the newest agree.

        Then see whether this machine keeps up, before the arm moves towards anybody.
        """
        step = steps.LOOK
        self._sightings.clear()
        self._surfaces.clear()
        self._looks.clear()
        with self._hearing_surfaces():
            settled = self._client.spin_until(
                lambda: steps.settled(self._sightings, _AGREEING, _SPREAD), step.timeout
            )
            self._client.spin_until(lambda: not settled or enough(self._surfaces), _LONGEST)
        self.pace = pace(self._surfaces if settled else self._looks, self.arm.period_deviation_p99)
        slow = too_slow(self.pace, _ALLOWED if settled else _PATIENCE)
        busy = slow and f"this machine is too slow, or too busy: {slow}"
        why = "" if settled else self._why("target_localizer", self._what_was_seen())
        if why or busy:
            raise StepError(step.name, "; or ".join(filter(None, (why, busy))))
        return self._sightings[-1]

    @contextmanager
    def _hearing_surfaces(self) -> Iterator[None]:
        node, hear = self._client.node, lambda raw: self._surfaces.append(self._arrival(stamp_of(raw)))
        surfaces = node.create_subscription(PointCloud2, "surface", hear, 5, raw=True)
        try:
            yield
        finally:
            node.destroy_subscription(surfaces)

    def gather(self, count: int, timeout: float) -> list[Sighting]:
        """Wait for so many contact targets, whether they agree or not; `timeout` in [s]."""
        self._sightings.clear()
        if not self._client.spin_until(lambda: len(self._sightings) >= count, timeout):
            raise StepError(steps.LOOK.name, self._why("target_localizer", self._what_was_seen()))
        return self._sightings[:count]

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._complaints[status.name] = status.message if status.level else ""

    def _on_arm(self, message: ArmState) -> None:
        self.arm = message

    def _on_targets(self, message: ContactTargets) -> None:
        targets, taken = targets_from_contact(message), stamp_seconds(message.header.stamp)
        self._looks.append(self._arrival(taken))
        self._regions_seen |= {target.region for target in targets}
        wanted = [target for target in targets if target.region == self._region]
        if wanted:
            best = max(wanted, key=lambda target: target.score)
            self._sightings.append(Sighting(taken, best))

    def _arrival(self, taken: float) -> Arrival:
        return Arrival(taken, 1e-9 * self._client.node.get_clock().now().nanoseconds)

    def _why(self, node: str, otherwise: str) -> str:
        said = self._complaints.get(node, "")
        return f"{otherwise}; {node} says: {said}" if said else otherwise

    def _what_was_seen(self) -> str:
        if self._sightings:
            count, spread = len(self._sightings), 1000 * _SPREAD
            return f"{count} targets of {self._region} do not agree within {spread:.0f} mm"
        others = ", ".join(sorted(self._regions_seen)) or "no region at all"
        return f"no contact target of {self._region} was found, but {others}"
