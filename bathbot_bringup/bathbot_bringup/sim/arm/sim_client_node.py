"""What a bench and the fault matrix ask of the simulated arm beside the protocol: its trace, and faults."""

import json
from collections.abc import Mapping
from pathlib import Path

from std_msgs.msg import String

from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient

_FAULT, _TRACE = "sim_fault", "sim_trace"
_WRITTEN = 10.0  # [s] for a trace to be on disk


class SimClient:
    """Talks to `sim_rm65` of one graph."""

    def __init__(self, client: GraphClient) -> None:
        """Join it."""
        self._client = client
        self._fault = client.node.create_publisher(String, _FAULT, 10)
        self._trace = client.node.create_publisher(String, _TRACE, 10)

    @property
    def heard(self) -> bool:
        """Whether the simulated arm listens by now."""
        return all(self._client.node.count_subscribers(topic) for topic in (_FAULT, _TRACE))

    def order(self, fault: Mapping[str, float | str]) -> None:
        """Order a fault of the emulated controller."""
        self._fault.publish(String(data=json.dumps(fault)))  # JSON is YAML

    def begin_trace(self) -> None:
        """Have the emulator forget what it recorded so far."""
        self._trace.publish(String(data=""))

    def write_trace(self, path: Path) -> None:
        """Have the emulator write its trace and wait for it.

        Raises:
            StepError: When it does not come.
        """
        self._trace.publish(String(data=str(path)))
        if not self._client.spin_until(path.is_file, _WRITTEN):
            raise StepError("trace", "sim_rm65 did not write its trace")
