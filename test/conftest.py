"""Fixtures for tests that run nodes."""

import os
import threading
import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from bathbot_depthcorr.node import stage_node
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class Graph:
    """Nodes that spin in one background thread while a test runs."""

    def __init__(self, context: Context, domain: int) -> None:
        self.domain = domain
        self._executor = SingleThreadedExecutor(context=context)
        self._nodes: list[Node] = []
        self._thread = threading.Thread(target=self._spin)

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except ExternalShutdownException:
            return

    def start(self, *nodes: Node) -> None:
        """Spin these nodes until the test ends."""
        for node in nodes:
            self._nodes.append(node)
            self._executor.add_node(node)
        if not self._thread.is_alive():
            self._thread.start()

    def stop(self) -> None:
        """Stop spinning first, then let the nodes go."""
        self._executor.shutdown()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
        for node in self._nodes:
            node.end() if isinstance(node, stage_node.StageNode) else node.destroy_node()

    @staticmethod
    def wait_for(condition: Callable[[], object], timeout: float = 10.0) -> None:
        """Return once the condition holds; fail the test when it does not in time [s]."""
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f"not within {timeout} s"
            time.sleep(0.01)


@pytest.fixture
def graph() -> Iterator[Graph]:
    """A graph on a domain of its own, so that no other node of this machine is heard."""
    domain = 1 + os.getpid() % 100
    rclpy.init(domain_id=domain)
    graph = Graph(rclpy.get_default_context(), domain)
    yield graph
    graph.stop()
    rclpy.try_shutdown()
