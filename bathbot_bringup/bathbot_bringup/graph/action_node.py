"""One action of the graph: a goal is sent, awaited and, when it takes too long, cancelled."""

from collections.abc import Callable
from typing import Any

from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle

from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient

Reason = Callable[[], str]
_CANCELLED = 2.0  # [s] for the answer to a cancel


class GraphAction:
    """A client of one action; it ends with the client of the graph."""

    def __init__(self, client: GraphClient, kind: type, name: str, answer: float = 5.0) -> None:
        """Make it some time before it is needed, as a service's.

        Args:
            client: Has joined the graph.
            kind: Of the action.
            name: Its name.
            answer: For the server to be there, and again to take a goal [s].
        """
        self._client, self._answer = client, answer
        self._action = ActionClient(client.node, kind, name)
        client.at_end(self._action.destroy)

    @property
    def offered(self) -> bool:
        """Whether a server is there."""
        return self._action.server_is_ready()

    def send(
        self,
        step: str,
        goal: Any,
        feedback: Callable[[Any], None] | None = None,
        refused: Reason = lambda: "the goal was not accepted",
    ) -> ClientGoalHandle:
        """Send a goal that somebody takes.

        Args:
            step: Of the job, for the error.
            goal: What to ask.
            feedback: Takes the feedback, each as it comes.
            refused: Gives the reason when nobody takes it.

        Raises:
            StepError: When nobody offers the action or takes the goal in time.
        """
        spin = self._client.spin_until
        if not spin(self._action.server_is_ready, self._answer):
            raise StepError(step, "nobody offers this action; is its node running?")
        show = None if feedback is None else lambda message: feedback(message.feedback)
        sent = self._action.send_goal_async(goal, feedback_callback=show)
        if not spin(sent.done, self._answer) or not sent.result().accepted:
            raise StepError(step, refused())
        return sent.result()

    def wait(self, step: str, sent: ClientGoalHandle, timeout: float, late: Reason) -> Any:
        """Wait for the result of a goal; one that takes too long is cancelled.

        Args:
            step: Of the job, for the error.
            sent: The goal.
            timeout: [s].
            late: Gives what else is known when it is not finished in time.

        Raises:
            StepError: When it is not.
        """
        result = sent.get_result_async()
        if not self._client.spin_until(result.done, timeout):
            self._client.spin_until(sent.cancel_goal_async().done, _CANCELLED)
            raise StepError(step, f"not finished within {timeout:.0f} s; {late()}")
        return result.result().result
