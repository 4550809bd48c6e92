"""The client that has a region looked for: it selects the region and gathers contact targets."""

from collections.abc import Callable

from bathbot_depthcorr.ros.messages import stamp_seconds
from bathbot_localize.messages import targets_from_contact
from diagnostic_msgs.msg import DiagnosticArray

from bathbot_bringup.bathing import steps
from bathbot_bringup.bathing.pace import Pace
from bathbot_bringup.bathing.pace_node import PaceWatch
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.msg import ArmState, ContactTargets
from bathbot_msgs.srv import SelectRegion

_AGREEING, _SPREAD = 5, 0.01  # sightings, [m]


class RegionFinder:
    """Looks for one region; what does not succeed raises `StepError` with a reason.

    Attributes:
        arm: What the driver said last.
        tell: Takes a line that a person should read at once.
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
        self._watch = PaceWatch(client)
        self.tell: Callable[[str], object] = lambda line: None
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
        step, why = steps.LOOK, ""
        self._sightings.clear()
        with self._watch.hearing():
            if self._client.spin_until(
                lambda: steps.settled(self._sightings, _AGREEING, _SPREAD), step.timeout
            ):
                self._watch.wait(lambda: self.arm.period_deviation_p99)
            else:
                why = self._why("target_localizer", self._what_was_seen())
        slow = self._watch.trouble(not why, self.arm.period_deviation_p99)
        if why or slow:
            raise StepError(step.name, "; or ".join(filter(None, (why, slow))))
        return self._sightings[-1]

    @property
    def pace(self) -> Pace | None:
        """How quickly this machine saw and moved while it was looked; None before."""
        return self._watch.pace

    def gather(self, count: int, timeout: float) -> list[Sighting]:
        """Wait for so many contact targets, whether they agree or not; `timeout` in [s]."""
        self._sightings.clear()
        if not self._client.spin_until(lambda: len(self._sightings) >= count, timeout):
            raise StepError(steps.LOOK.name, self._why("target_localizer", self._what_was_seen()))
        return self._sightings[:count]

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            said = status.message if status.level else ""
            if status.name == "recorder" and bool(said) != bool(self._complaints.get("recorder")):
                self.tell(f"the recorder says: {status.message}")
            self._complaints[status.name] = said

    def _on_arm(self, message: ArmState) -> None:
        self.arm = message

    def _on_targets(self, message: ContactTargets) -> None:
        targets, taken = targets_from_contact(message), stamp_seconds(message.header.stamp)
        self._watch.looked(taken)
        self._regions_seen |= {target.region for target in targets}
        wanted = [target for target in targets if target.region == self._region]
        if wanted:
            best = max(wanted, key=lambda target: target.score)
            self._sightings.append(Sighting(taken, best))

    def _why(self, node: str, otherwise: str) -> str:
        said = self._complaints.get(node, "")
        return f"{otherwise}; {node} says: {said}" if said else otherwise

    def _what_was_seen(self) -> str:
        if self._sightings:
            count, spread = len(self._sightings), 1000 * _SPREAD
            return f"{count} targets of {self._region} do not agree within {spread:.0f} mm"
        others = ", ".join(sorted(self._regions_seen)) or "no region at all"
        return f"no contact target of {self._region} was found, but {others}"
