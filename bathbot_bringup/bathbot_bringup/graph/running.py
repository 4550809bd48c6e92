"""A graph of our nodes that nobody else hears: started, awaited, watched and ended, written once.

    with running({"sim_camera": {"seed": 3}}, logs, "bathbot_guest") as graph:
        graph.client.wait(5.0)

Inside, every node is active, and one that dies raises ProcessError in whatever the client waits for; at the
end, however it comes about, every process has ended.
"""

import itertools
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.node_table import Parameters, find_node, node_command
from bathbot_bringup.graph.processes import (
    NODE_PATIENCE,
    Child,
    Patience,
    ProcessGroup,
    isolated_environment,
)
from bathbot_bringup.graph.register import registered

if TYPE_CHECKING:
    from bathbot_bringup.graph.client_node import GraphClient

START = 60.0  # [s] until all nodes are active; a quiet machine takes a few
_OTHER = 37  # between the domains that one program wishes for; no divisor of their number
_graphs = itertools.count()


class RunningGraph:
    """Processes of one DDS domain, and a client in this process that talks to them.

    Attributes:
        domain: DDS domain.
        group: The processes.
        client: Has joined them.
    """

    def __init__(self, domain: int, group: ProcessGroup, client: "GraphClient") -> None:
        """Hold what was begun; see `started`."""
        self.domain, self.group, self.client = domain, group, client

    def start(self, name: str, parameters: Parameters | None = None) -> Child:
        """Start one more node.

        Raises:
            InputError: When there is no node of this name.
        """
        return start_node(self.group, name, parameters)

    def wait_until_active(self, timeout: float = START) -> None:
        """Wait until every node is active; from then on a death raises ProcessError in every wait.

        Args:
            timeout: For all together [s].

        Raises:
            ProcessError: When a node dies or is late.
        """
        self.group.wait_until(self.client.is_active, timeout)
        self.client.watch = self.group.check


def start_node(group: ProcessGroup, name: str, parameters: Parameters | None = None) -> Child:
    """Start a node of the table, as gently as its row says.

    Raises:
        InputError: When there is no node of this name.
    """
    entry = find_node(name)
    return group.start(entry.name, node_command(entry, parameters), entry.niceness, entry.last)


@contextmanager
def started(
    nodes: Mapping[str, Parameters], logs: Path, client: str, patience: Patience = NODE_PATIENCE
) -> Iterator[RunningGraph]:
    """Start nodes on a domain of their own and join them; they are not awaited yet.

    Args:
        nodes: Parameters of each node by its name, in the order they are started.
        logs: Folder for their lines, one file per node.
        client: Name of the client.
        patience: How the processes are ended.

    Raises:
        InputError: When there is no node of a name.
    """
    from bathbot_bringup.graph.client_node import GraphClient  # ROS only once a graph is wanted

    domain = free_domain(os.getpid() + _OTHER * next(_graphs), used_ports())
    with registered(domain), ProcessGroup(logs, isolated_environment(domain, logs), patience) as group:
        for name, parameters in nodes.items():
            start_node(group, name, parameters)
        with GraphClient(client, domain) as joined:
            yield RunningGraph(domain, group, joined)


@contextmanager
def running(
    nodes: Mapping[str, Parameters],
    logs: Path,
    client: str,
    timeout: float = START,
    patience: Patience = NODE_PATIENCE,
) -> Iterator[RunningGraph]:
    """Start nodes as `started` does, and wait until all are active.

    Args:
        nodes: Parameters of each node by its name, in the order they are started.
        logs: Folder for their lines, one file per node.
        client: Name of the client.
        timeout: Until all are active [s].
        patience: How the processes are ended.

    Raises:
        ProcessError: When a node dies or is late.
    """
    with started(nodes, logs, client, patience) as graph:
        graph.wait_until_active(timeout)
        yield graph
