"""The client that has a region bathed: select, look, approach, scrub, retract, home."""

import time
from collections.abc import Callable
from typing import Any

from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.arm.states import State
from std_srvs.srv import Trigger

from bathbot_bringup.bathing import steps
from bathbot_bringup.bathing.finder_node import RegionFinder
from bathbot_bringup.bathing.steps import Sighting, Step
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.action_node import GraphAction
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.action import Approach, Scrub

Progress = Callable[[float, str], None]
_LATE_REPORTS = 0.2  # [s]
_SETTLING = 3.0  # [s] within which the planner must have heard of the contact


class Bather(RegionFinder):
    """Does the steps of the job one after the other; each raises `StepError` with a reason."""

    def __init__(self, client: GraphClient, region: str) -> None:
        """Listen to targets and to the arm.

        Args:
            client: Has joined the graph.
            region: Full name, such as `Trunk_skin`.
        """
        super().__init__(client, region)
        self._approach = GraphAction(client, Approach, "approach")
        self._scrub = GraphAction(client, Scrub, "scrub")
        for service in ("arm/stop", "arm/retract", "arm/home"):
            client.service(Trigger, service)

    def connect(self) -> None:
        """Wait until the driver hears its controller."""
        step = steps.CONNECT
        if not self._client.spin_until(lambda: self.arm.connected, step.timeout):
            heard = self.arm.header.frame_id or self.arm.reason
            reason = self.arm.reason or "the driver hears no controller"
            silent = "no arm_state is published; is rm65_driver running?"
            raise StepError(step.name, reason if heard else silent)

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
            self._client.wait(_LATE_REPORTS)
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

    def _outcome(self, step: Step, action: GraphAction, goal: Any, show: Callable[[Any], None]) -> Any:
        """Send a goal and wait for its result."""
        refused = "the goal was not accepted"
        sent = action.send(step.name, goal, show, lambda: self._why("rm65_driver", refused))
        return action.wait(step.name, sent, step.timeout, lambda: self.arm.reason or "no reason known")


def _demand_success(step: Step, outcome: Any) -> Any:
    """Give the result of an action, or raise StepError with its reason."""
    if outcome.error_code != type(outcome).NONE:
        raise StepError(step.name, outcome.error_msg or f"error code {outcome.error_code}")
    return outcome
