"""The graph of one seed: emulator beside a person, driver, and the operator in this process."""

import contextlib
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from bathbot_scrub.rm65.controller.client import ArmClient
from numpy.typing import NDArray

from bathbot_bringup.evaluation.safety.trial.trial_site import TrialSite
from bathbot_bringup.graph.isolation import Ports, free_ports
from bathbot_bringup.graph.node_table import Parameters, find_node, node_command
from bathbot_bringup.graph.processes import Patience
from bathbot_bringup.graph.running import START, RunningGraph, running

if TYPE_CHECKING:
    from bathbot_bringup.evaluation.safety.trial.fake_localizer_node import FakeLocalizer

Array = NDArray[np.float64]
_CONNECT = 20.0  # [s]
_PATIENCE: Patience = ((signal.SIGINT, 4.0), (signal.SIGKILL, 2.0))
_MEND = ({"command": "set_arm_power", "arm_power": 1}, {"command": "clear_system_err"})


class TrialGraph:
    """Running processes of one seed, and what may be done to them."""

    def __init__(self, graph: RunningGraph, ports: Ports) -> None:
        """Add the operator to what runs; `ports` are those of the controller."""
        from bathbot_bringup.evaluation.safety.trial.operator_node import Operator  # ROS only with a graph

        self._graph, self._ports = graph, ports
        self.client, self.operator = graph.client, Operator(graph.client)

    def start(self, name: str, command: list[str]) -> None:
        """Start one more process."""
        self._graph.group.start(name, command)

    def start_planner(self) -> None:
        """Start the real planner, unless it runs already."""
        name = "scrub_planner"
        if not any(child.name == name for child in self._graph.group.children):
            self.start(name, node_command(find_node(name)))  # served like the driver: both are judged
        self._graph.group.wait_until(self.client.is_active, START)

    def localizer(self, skin: Array, T_base_target: Array) -> "FakeLocalizer":
        """Play camera, detector and localiser for the real planner; a context manager.

        Args:
            skin: Organised points in the base frame [m], shape (H, W, 3).
            T_base_target: Contact target, z into the skin, (4, 4).
        """
        from bathbot_bringup.evaluation.safety.trial.fake_localizer_node import FakeLocalizer

        return FakeLocalizer(self.client, skin, T_base_target)

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
        child = next(child for child in self._graph.group.children if child.name == name)
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
def trial_graph(seed: int, site: TrialSite, logs: Path) -> Iterator[TrialGraph]:
    """Run the graph of one seed.

    Args:
        seed: Of the person.
        site: Where the arm waits.
        logs: Folder for the logs.

    Raises:
        BringupError: When it does not come up.
    """
    ports = free_ports()
    ready = [float(angle) for angle in np.degrees(site.ready)]
    nodes: dict[str, Parameters] = {
        "sim_rm65": {"seed": seed, "port": ports.tcp, "udp_port": ports.udp, "joints_deg": ready,
                     "epoch": time.time()},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp, "home_deg": ready},
    }  # fmt: skip
    with running(nodes, logs, "bathbot_safety", patience=_PATIENCE) as graph:
        trials = TrialGraph(graph, ports)
        trials.operator.connect(_CONNECT)
        yield trials
