"""A node that asks the graph and waits for answers; the caller's own thread does the spinning."""

import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import rclpy
from bathbot_depthcorr.node.dds.participant_node import begin, joining
from lifecycle_msgs.srv import GetState
from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.interruption import forget_interruption, held_back, raise_if_interrupted

_TICK = 0.02  # [s]


class GraphClient:
    """Talks to a graph of one DDS domain; use it as a context manager."""

    def __init__(self, name: str, domain: int | None = None) -> None:
        """Join the domain; None takes the environment's, whose transport its processes share."""
        begin(domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        with joining():
            self.node = Node(f"{name}_{os.getpid()}")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._clients: dict[str, Client] = {}
        self._ends = ExitStack()
        self.watch: Callable[[], None] = lambda: None

    def __enter__(self) -> "GraphClient":
        """Begin."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph in order, and entirely: what stays behind would hold up the end of the process."""
        self._executor.shutdown()
        self._ends.close()
        self._clients.clear()
        self.node.destroy_node()
        rclpy.try_shutdown()

    def spin_until(self, condition: Callable[[], Any], timeout: float) -> bool:
        """Serve callbacks until the condition holds; tell whether it did within `timeout` [s].

        `watch` is called all the while; what it raises ends the wait.
        """
        deadline = time.monotonic() + timeout
        forget_interruption()
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._serve()
            self.watch()
            raise_if_interrupted()
        return True

    def wait(self, seconds: float) -> None:
        """Serve callbacks for a while [s]; `watch` is called all the while."""
        self.spin_until(lambda: False, seconds)

    def _serve(self) -> None:
        """Serve callbacks; an interruption inside the conversion of a message would end as another error."""
        with held_back():
            self._executor.spin_once(timeout_sec=_TICK)

    def at_end(self, end: Callable[[], None]) -> None:
        """Call `end` when this client leaves: for what a node does not destroy itself."""
        self._ends.callback(end)

    def service(self, kind: type, name: str) -> Client:
        """Make a client of a service, or give the one made before; it ends with this one.

        Make it early: a server that has not discovered its client yet drops the answer.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        return self._clients[name]

    def is_active(self, name: str) -> bool:
        """Ask a lifecycle node whether it is active; false while it does not answer."""
        client = self.service(GetState, f"{name}/get_state")
        if not client.service_is_ready():
            self._serve()
            return False
        future = client.call_async(GetState.Request())
        return self.spin_until(future.done, 2.0) and future.result().current_state.label == "active"

    def call(self, step: str, kind: type, service: str, request: Any, timeout: float, tries: int = 1) -> Any:
        """Call a service and wait for its response.

        Args:
            step: Of the job, for the error.
            kind: Of the service.
            service: Its name.
            request: What to ask.
            timeout: [s], for all tries together.
            tries: How often to ask; more than once only where asking twice does no harm.

        Raises:
            StepError: When the service is not offered or does not answer in time.
        """
        client, deadline = self.service(kind, service), time.monotonic() + timeout
        if not self.spin_until(client.service_is_ready, timeout):
            raise StepError(step, f"nobody offers the service {service}; is its node running?")
        for left in range(tries, 0, -1):
            future = client.call_async(request)
            if self.spin_until(future.done, max((deadline - time.monotonic()) / left, 0.1)):
                return future.result()
            client.remove_pending_request(future)
        raise StepError(step, f"the service {service} did not answer within {timeout:.0f} s")

    def trigger(self, step: str, service: str, timeout: float) -> str:
        """Call a Trigger service and give its message.

        Raises:
            StepError: When it is not offered, late, or answers that it failed.
        """
        response = self.call(step, Trigger, service, Trigger.Request(), timeout)
        if not response.success:
            raise StepError(step, response.message or f"the service {service} refused without a reason")
        return response.message
