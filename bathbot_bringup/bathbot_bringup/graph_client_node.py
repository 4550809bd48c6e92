"""A node that asks the graph and waits for answers; the caller's own thread does the spinning."""

import os
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

import rclpy
from lifecycle_msgs.srv import GetState
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from bathbot_bringup.errors import StepError
from bathbot_depthcorr import stage_node  # noqa: F401 - keeps DDS on this machine, before the first context

_TICK = 0.02  # [s]


class GraphClient:
    """Talks to a graph of one DDS domain; use it as a context manager."""

    def __init__(self, name: str, domain: int | None = None) -> None:
        """Join the domain; None takes the one of the environment.

        Processes that were started with this program's environment share its transport settings.
        """
        rclpy.init(domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node(f"{name}_{os.getpid()}")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._states: dict[str, Client] = {}
        self._actions: list[ActionClient] = []
        self.watch: Callable[[], None] = lambda: None

    def __enter__(self) -> "GraphClient":
        """Begin."""
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Leave the graph in order, and entirely: what stays behind would hold up the end of the process."""
        self._executor.shutdown()
        for action in self._actions:  # a node does not destroy these itself
            action.destroy()
        self._actions.clear()
        self._states.clear()
        self.node.destroy_node()
        rclpy.try_shutdown()

    def spin_until(self, condition: Callable[[], Any], timeout: float) -> bool:
        """Serve callbacks until the condition holds.

        `watch` is called all the while; what it raises ends the wait.

        Args:
            condition: Asked after each round of callbacks.
            timeout: [s].

        Returns:
            Whether the condition held in time.
        """
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=_TICK)
            self.watch()
        return True

    def action(self, kind: type, name: str) -> ActionClient:
        """Make a client of an action; it ends with this one."""
        self._actions.append(ActionClient(self.node, kind, name))
        return self._actions[-1]

    def is_active(self, name: str) -> bool:
        """Ask a lifecycle node whether it is active; false while it does not answer."""
        client = self._states.setdefault(name, self.node.create_client(GetState, f"{name}/get_state"))
        if not client.service_is_ready():
            self._executor.spin_once(timeout_sec=_TICK)
            return False
        future = client.call_async(GetState.Request())
        answered = self.spin_until(future.done, 2.0)
        return answered and future.result().current_state.label == "active"

    def call(self, step: str, kind: type, service: str, request: Any, timeout: float) -> Any:
        """Call a service and wait for its response.

        Raises:
            StepError: When the service is not offered or does not answer in time.
        """
        client = self.node.create_client(kind, service)
        try:
            deadline = time.monotonic() + timeout
            if not self.spin_until(client.service_is_ready, timeout):
                raise StepError(step, f"nobody offers the service {service}; is its node running?")
            future = client.call_async(request)
            if not self.spin_until(future.done, max(deadline - time.monotonic(), 0.1)):
                raise StepError(step, f"the service {service} did not answer within {timeout:.0f} s")
            return future.result()
        finally:
            self.node.destroy_client(client)

    def trigger(self, step: str, service: str, timeout: float) -> str:
        """Call a Trigger service and give its message.

        Raises:
            StepError: When it is not offered, late, or answers that it failed.
        """
        response = self.call(step, Trigger, service, Trigger.Request(), timeout)
        if not response.success:
            raise StepError(step, response.message or f"the service {service} refused without a reason")
        return response.message
