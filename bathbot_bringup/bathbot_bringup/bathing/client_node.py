"""The client that has a region bathed: select, look, approach, scrub, retract, home."""

import time
from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.ros.messages import stamp_seconds
from bathbot_localize.messages import pose_from_transform, targets_from_contact
from bathbot_scrub.rm65.guard.states import State
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger

from bathbot_bringup.bathing import steps
from bathbot_bringup.bathing.steps import Sighting, Step
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.action import Approach, Scrub
from bathbot_msgs.msg import ArmState, ContactTargets
from bathbot_msgs.srv import SelectRegion

Progress = Callable[[float, str], None]
_AGREEING, _SPREAD = 5, 0.01  # sightings, [m]
_LATE_REPORTS = 0.2  # [s]
_SETTLING = 3.0  # [s] within which the planner must have heard of the contact


class Bather:
    """Does the steps of the job one after the other; each raises `StepError` with a reason."""

    def __init__(self, client: GraphClient, region: str) -> None:
        """Listen to targets and to the arm.

        Args:
            client: Has joined the graph.
            region: Full name, such as `Trunk_skin`.
        """
        self._client, self._region = client, region
        node: Node = client.node
        self.arm = ArmState()
        self.sightings: list[Sighting] = []
        self.complaints: dict[str, str] = {}
        self._regions_seen: set[str] = set()
        self._approach = client.action(Approach, "approach")
        self._scrub = client.action(Scrub, "scrub")
        client.service(SelectRegion, "select_region")
        for service in ("arm/stop", "arm/retract", "arm/home"):
            client.service(Trigger, service)
        node.create_subscription(ArmState, "arm_state", self._on_arm, 10)
        node.create_subscription(ContactTargets, "contact_targets", self._on_targets, 10)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 50)

    def connect(self) -> None:
        """Wait until the driver hears its controller."""
        step = steps.CONNECT
        if not self._client.spin_until(lambda: self.arm.connected, step.timeout):
            heard = self.arm.header.frame_id or self.arm.reason
            reason = self.arm.reason or "the driver hears no controller"
            silent = "no arm_state is published; is rm65_driver running?"
            raise StepError(step.name, reason if heard else silent)

    def select(self) -> None:
        """Tell the localiser which region is wanted."""
        step = steps.SELECT
        request = SelectRegion.Request(region=self._region)
        response = self._client.call(
            step.name, SelectRegion, "select_region", request, step.timeout, attempts=3
        )
        if response.error_code != SelectRegion.Response.NONE:
            raise StepError(step.name, response.error_msg)

    def look(self) -> Sighting:
        """Gather targets while the arm is out of the way, until the newest agree."""
        step = steps.LOOK
        self.sightings.clear()
        if not self._client.spin_until(
            lambda: steps.settled(self.sightings, _AGREEING, _SPREAD), step.timeout
        ):
            raise StepError(step.name, self._why("target_localizer", self._what_was_seen()))
        return self.sightings[-1]

    def gather(self, count: int, timeout: float) -> list[Sighting]:
        """Wait for so many contact targets, whether they agree or not; `timeout` in [s]."""
        self.sightings.clear()
        if not self._client.spin_until(lambda: len(self.sightings) >= count, timeout):
            raise StepError(steps.LOOK.name, self._why("target_localizer", self._what_was_seen()))
        return self.sightings[:count]

    def approach(self, sighting: Sighting, progress: Progress) -> Approach.Result:
        """Move to the target until skin is felt."""
        goal = Approach.Goal(region=self._region)
        goal.target.header.frame_id = "base_link"
        goal.target.header.stamp = self._client.node.get_clock().now().to_msg()
        goal.target.pose = pose_from_transform(sighting.target.T_base_target)

        def show(feedback: Any) -> None:
            progress(0.0, f"{1000 * feedback.remaining:.0f} mm to go, {feedback.force:.1f} N")

        return _demand_success(steps.APPROACH, self._outcome(steps.APPROACH, self._approach, goal, show))

    def scrub(self, max_length: float, progress: Progress) -> Scrub.Result:
        """Scrub the region; `max_length` of path [m], 0 for the whole patch."""

        def show(feedback: Any) -> None:
            progress(feedback.fraction, f"segment {feedback.segment_index}, {self.arm.force:.1f} N")

        goal, deadline = Scrub.Goal(region=self._region, max_length=max_length), time.monotonic() + _SETTLING
        outcome = self._outcome(steps.SCRUB, self._scrub, goal, show)
        while outcome.error_code == Scrub.Result.NOT_READY and time.monotonic() < deadline:
            # the planner may hear of the contact later than we do
            self._client.spin_until(lambda: False, _LATE_REPORTS)
            outcome = self._outcome(steps.SCRUB, self._scrub, goal, show)
        return _demand_success(steps.SCRUB, outcome)

    def retract(self) -> None:
        """Leave the skin along its outward normal and wait until the arm stands."""
        self._move(steps.RETRACT, "arm/retract", (State.HOLD, State.FREE))

    def home(self) -> None:
        """Go home and wait until the arm is there."""
        self._move(steps.HOME, "arm/home", (State.FREE,))

    def _move(self, step: Step, service: str, ends: tuple[State, ...]) -> None:
        """Ask for a motion and wait until it has ended in one of the states `ends`."""
        self._client.trigger(step.name, service, step.timeout)
        asked = time.monotonic()

        def over() -> bool:  # reports sent before the motion began may still be on their way
            stopped = self.arm.state in (*ends, State.HOLD, State.FAULT)
            return time.monotonic() - asked > _LATE_REPORTS and stopped

        if not self._client.spin_until(over, step.timeout):
            raise StepError(
                step.name, f"the arm was not there within {step.timeout:.0f} s; {self.arm.reason}"
            )
        if self.arm.state not in ends:
            raise StepError(step.name, self.arm.reason or "the arm stopped on the way")

    def withdraw(self) -> None:
        """Leave the skin after a step that failed, as far as the arm still can, and go home."""
        leaving = State.RETRACTING  # it has done so by itself after too high a force
        self._client.spin_until(lambda: self.arm.state != leaving, steps.RETRACT.timeout)
        if self.arm.state in (State.CONTACT, State.HOLD):
            self.retract()
        self.home()

    def stop_arm(self) -> None:
        """Stop the arm where it is, now."""
        self._client.watch = lambda: None
        self._client.trigger("stop", "arm/stop", 2.0)

    def _outcome(self, step: Step, action: ActionClient, goal: Any, show: Callable[[Any], None]) -> Any:
        """Send a goal and wait for its result; a goal that takes too long is cancelled."""
        spin = self._client.spin_until
        if not spin(action.server_is_ready, 5.0):
            raise StepError(step.name, "nobody offers this action; is its node running?")
        sent = action.send_goal_async(goal, feedback_callback=lambda message: show(message.feedback))
        if not spin(sent.done, 5.0) or not sent.result().accepted:
            raise StepError(step.name, self._why("rm65_driver", "the goal was not accepted"))
        result = sent.result().get_result_async()
        if not spin(result.done, step.timeout):
            spin(sent.result().cancel_goal_async().done, 2.0)
            raise StepError(
                step.name, f"not finished within {step.timeout:.0f} s; {self.arm.reason or 'no reason known'}"
            )
        return result.result().result

    def _on_arm(self, message: ArmState) -> None:
        self.arm = message

    def _on_targets(self, message: ContactTargets) -> None:
        targets = targets_from_contact(message)
        self._regions_seen |= {target.region for target in targets}
        wanted = [target for target in targets if target.region == self._region]
        if wanted:
            best = max(wanted, key=lambda target: target.score)
            self.sightings.append(Sighting(stamp_seconds(message.header.stamp), best))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.complaints[status.name] = status.message if status.level else ""

    def _why(self, node: str, otherwise: str) -> str:
        said = self.complaints.get(node, "")
        return f"{otherwise}; {node} says: {said}" if said else otherwise

    def _what_was_seen(self) -> str:
        if self.sightings:
            return (
                f"{len(self.sightings)} targets of {self._region} do not agree within {1000 * _SPREAD:.0f} mm"
            )
        others = ", ".join(sorted(self._regions_seen)) or "no region at all"
        return f"no contact target of {self._region} was found, but {others}"


def _demand_success(step: Step, outcome: Any) -> Any:
    """Give the result of an action, or raise StepError with its reason."""
    if outcome.error_code != type(outcome).NONE:
        raise StepError(step.name, outcome.error_msg or f"error code {outcome.error_code}")
    return outcome
