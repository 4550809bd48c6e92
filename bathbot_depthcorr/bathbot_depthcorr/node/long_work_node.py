"""What takes long, on an executor that must not wait: actions, and services of a call.

Such work is done in a thread. A goal is executed when its work has ended, which in the executor takes no
time: it only tells the outcome. So a goal's status stays ACCEPTED until it ends; a coroutine that waits
would keep the executor busy.
"""

import threading
from collections.abc import Awaitable, Callable
from typing import Any, Generic, TypeVar

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from bathbot_depthcorr.errors import BathbotError

Outcome = TypeVar("Outcome")
Answer = Callable[[Trigger.Request, Trigger.Response], Trigger.Response]
SlowAnswer = Callable[[Trigger.Request, Trigger.Response], Awaitable[Trigger.Response]]
Call = Callable[[], str | None]


class LongAction(Generic[Outcome]):
    """Takes every goal; each ends once, with the outcome that `end` or `run` gives it."""

    def __init__(
        self,
        node: Node,
        action_type: type,
        name: str,
        begin: Callable[[ServerGoalHandle], None],
        conclude: Callable[[ServerGoalHandle, Outcome], Any],
        cancel: Callable[[], None] = lambda: None,
    ) -> None:
        """Offer the action.

        Args:
            node: That owns it.
            action_type: Of the action.
            name: Of the action.
            begin: Called in the executor with a new goal; calls `end` or `run`, and does not wait.
            conclude: Called in the executor with a goal and its outcome; sets the goal's final state and
                gives its result.
            cancel: Called in the executor when a goal shall be cancelled; that is always granted.
        """
        self._conclude, self._cancel = conclude, cancel
        self._outcomes: dict[bytes, Outcome] = {}  # of goals that have ended, by their id
        self._server = ActionServer(
            node, action_type, name, self._tell, handle_accepted_callback=begin,
            goal_callback=lambda _: GoalResponse.ACCEPT, cancel_callback=self._on_cancel,
        )  # fmt: skip

    def run(self, goal: ServerGoalHandle, work: Callable[[], Outcome]) -> None:
        """Call `work`, which must not raise, in a thread of its own and end the goal with what it gives."""
        threading.Thread(target=lambda: self.end(goal, work()), name="goal", daemon=True).start()

    def end(self, goal: ServerGoalHandle, outcome: Outcome) -> None:
        """End a goal, from any thread."""
        self._outcomes[bytes(goal.goal_id.uuid)] = outcome
        goal.execute()

    def close(self) -> None:
        """Offer it no more."""
        self._server.destroy()

    def _tell(self, goal: ServerGoalHandle) -> Any:
        return self._conclude(goal, self._outcomes.pop(bytes(goal.goal_id.uuid)))

    def _on_cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        self._cancel()
        return CancelResponse.ACCEPT


def at_once(node: Node, call: Call) -> Answer:
    """Answer by a call that takes no time, in the executor; a refusal is also logged."""

    def serve(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        _fill(response, outcome_of(node, call))
        if not response.success:
            node.get_logger().warning(response.message)
        return response

    return serve


def beside(node: Node, call: Call) -> SlowAnswer:
    """Answer by a call in a thread of its own; in a callback group of its own others are heard meanwhile."""

    async def serve(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        future = Future(executor=node.executor)
        work = lambda: future.set_result(outcome_of(node, call))  # noqa: E731
        threading.Thread(target=work, name="trigger", daemon=True).start()
        _fill(response, await future)
        return response

    return serve


def _fill(response: Trigger.Response, outcome: str | Exception | None) -> None:
    response.success = not isinstance(outcome, Exception)
    response.message = str(outcome or "")


def outcome_of(node: Node, call: Callable[[], Outcome]) -> Outcome | BathbotError:
    """What a call gives, or its error; one that is no user's fault is logged, or nobody would see it."""
    try:
        return call()
    except BathbotError as error:
        return error
    except Exception as error:  # a caller must get an answer, whatever happened
        message = f"{type(error).__name__}: {error}"
        node.get_logger().fatal(message)
        return BathbotError(message)
