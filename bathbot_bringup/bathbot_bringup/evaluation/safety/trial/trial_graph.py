"""The graph of one seed: emulator beside a person, driver, and the operator in this process."""

import contextlib
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from bathbot_scrub.rm65.controller.client import ArmClient

from bathbot_bringup.bathing.nodes import Ports, free_ports
from bathbot_bringup.evaluation.safety.trial.operator_node import Operator
from bathbot_bringup.evaluation.safety.trial.site import Place
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import Patience, ProcessGroup, isolated_environment

_START, _CONNECT = 60.0, 20.0  # [s]
_PATIENCE: Patience = ((signal.SIGINT, 4.0), (signal.SIGKILL, 2.0))
_MEND = ({"command": "set_arm_power", "arm_power": 1}, {"command": "clear_system_err"})


class TrialGraph:
    """Running processes of one seed, and what may be done to them."""

    def __init__(self, group: ProcessGroup, client: GraphClient, ports: Ports) -> None:
        """Wrap what was started."""
        self._group, self._ports = group, ports
        self.client, self.operator = client, Operator(client)

    def connect(self) -> None:
        """Wait until all is up; from then on a process that dies raises ProcessError in every wait."""
        self._group.wait_until(self.client.is_active, _START)
        self.client.watch = self._group.check
        self.operator.connect(_CONNECT)

    def start(self, name: str, command: list[str]) -> None:
        """Start one more process."""
        self._group.start(name, command)

    def start_planner(self) -> None:
        """Start the real planner, unless it runs already."""
        name = "scrub_planner"
        if not any(child.name == name for child in self._group.children):
            self.start(name, node_command(find_node(name), {}))
        self._group.wait_until(self.client.is_active, _START)

    def kill(self, name: str) -> float:
        """End a process at once; gives the time [s]. Nobody watches over the graph any more."""
        self.client.watch = lambda: None
        return self._signal(name, signal.SIGKILL)

    def freeze(self, name: str) -> float:
        """Let a process stand still; gives the time [s]."""
        return self._signal(name, signal.SIGSTOP)

    def thaw(self, name: str) -> float:
        """Let it go on; gives the time [s]."""
        return self._signal(name, signal.SIGCONT)

    def _signal(self, name: str, number: signal.Signals) -> float:
        child = next(child for child in self._group.children if child.name == name)
        child.process.send_signal(number)
        return time.monotonic()

    def mend(self) -> None:
        """Do what a technician does after a fault: power on, errors cleared."""
        arm = ArmClient("127.0.0.1", self._ports.tcp)
        arm.start()
        try:
            if self.client.spin_until(lambda: arm.connection.connected, _CONNECT):
                for frame in _MEND:
                    arm.request(frame)
        finally:
            arm.close()


@contextlib.contextmanager
def trial_graph(seed: int, place: Place, logs: Path) -> Iterator[TrialGraph]:
    """Run the graph of one seed.

    Args:
        seed: Of the person.
        place: Where the arm waits.
        logs: Folder for the logs.

    Raises:
        BringupError: When it does not come up.
    """
    domain, ports = free_domain(os.getpid() + time.monotonic_ns() // 1000, used_ports()), free_ports()
    ready = [float(angle) for angle in np.degrees(place.ready)]
    parameters: dict[str, dict[str, object]] = {
        "sim_rm65": {"seed": seed, "port": ports.tcp, "udp_port": ports.udp, "joints_deg": ready,
                     "epoch": time.time()},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp, "home_deg": ready},
    }  # fmt: skip
    with ProcessGroup(logs, isolated_environment(domain, logs), _PATIENCE) as group:
        for name, values in parameters.items():
            group.start(name, node_command(find_node(name), values))
        with GraphClient("bathbot_safety", domain) as client:
            graph = TrialGraph(group, client, ports)
            graph.connect()
            yield graph
