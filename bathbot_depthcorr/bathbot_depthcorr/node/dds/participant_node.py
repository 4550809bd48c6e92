"""A process joins the graph: from then on nobody reaches it but whom the reach allows."""

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import rclpy
from rclpy import get_default_context
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation

from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.dds import reach, shared_memory, socket_filter, transport, udp_ports
from bathbot_depthcorr.node.dds.reach import Reach

os.environ.update(transport.variables())  # which the first context reads

_LOOK = 0.2  # [s] between looks at whose the ports of this machine are; who is new is heard that much later


def begin(**options: Any) -> None:
    """Do what `rclpy.init` does, where the reach can be kept to; ROS tells missing keys in many lines.

    Raises:
        SettingsError: When the environment asks for a reach that cannot be kept to.
    """
    reach.chosen()
    rclpy.init(**options)


@contextmanager
def joining(context: Context | None = None) -> Iterator[Reach]:
    """Make a node within this, or nobody keeps strangers from it; gives the reach.

    Args:
        context: The node's; None: the default one.

    Raises:
        SettingsError: When the environment asks for a reach that cannot be kept to, or DDS refuses its keys.
        ForeignMemoryError: When another user sits where this process would be spoken to.
    """
    wanted = reach.chosen()
    if wanted is Reach.NETWORK:
        try:
            yield wanted
        except rclpy_implementation.RCLError as error:  # the context is joined with the first node
            raise SettingsError(
                f"no node can join with these keys: {' '.join(str(error).split())}; docs/privacy.md tells "
                "what they allow; the Fast DDS of Ubuntu's ROS was built with security, pip's was not"
            ) from error
        return
    shared_memory.clean()
    if transport.shares_memory():
        shared_memory.refuse_foreign(udp_ports.of_domain((context or get_default_context()).get_domain_id()))
    before = _own_sockets()
    yield wanted
    shared_memory.close_to_others()
    if wanted is Reach.USER:
        _FILTER.watch(_own_sockets() - before)


def _own_sockets() -> frozenset[tuple[int, int]]:
    """UDP sockets of this process: descriptor and inode."""
    inodes = {f"socket:[{port.inode}]": port.inode for port in udp_ports.read()}
    found = ((int(name), inodes.get(_link(name), 0)) for name in os.listdir("/proc/self/fd"))
    return frozenset((descriptor, inode) for descriptor, inode in found if inode)


def _link(descriptor: str) -> str:
    try:
        return os.readlink(f"/proc/self/fd/{descriptor}")
    except FileNotFoundError:
        return ""


class _PeerFilter:
    """Keeps filters on sockets of DDS as ports come and go, as long as there are such sockets."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._sockets: frozenset[tuple[int, int]] = frozenset()
        self._ports: frozenset[int] = frozenset()
        self._thread: threading.Thread | None = None

    def watch(self, sockets: frozenset[tuple[int, int]]) -> None:
        """Filter these sockets, now and until they are closed."""
        with self._lock:
            self._sockets |= sockets
            self._ports = frozenset()
            self._look()
            if self._thread is None and self._sockets:
                self._thread = threading.Thread(target=self._work, name="peers", daemon=True)
                self._thread.start()

    def _work(self) -> None:
        while True:
            time.sleep(_LOOK)
            with self._lock:
                self._look()
                if not self._sockets:
                    self._thread = None
                    return

    def _look(self) -> None:
        if transport.shares_memory():
            shared_memory.close_to_others()  # also what came later, and other programs' of this user
        self._sockets = frozenset(one for one in self._sockets if _link(str(one[0])) == f"socket:[{one[1]}]")
        ports = udp_ports.trusted(udp_ports.read(), (os.geteuid(), 0))
        if ports != self._ports:
            for descriptor, _ in self._sockets:
                with suppress(OSError):  # closed this moment; the next look forgets it
                    socket_filter.attach(descriptor, ports)
            self._ports = ports


_FILTER = _PeerFilter()
