"""Whom the sockets of this process hear: ports of trusted users, as these come and go."""

import os
import threading
import time
from contextlib import suppress

from bathbot_depthcorr.node.dds import shared_memory, socket_filter, transport, udp_ports

_LOOK = 0.2  # [s] between looks at whose the ports of this machine are; who is new is heard that much later


def own_sockets() -> frozenset[tuple[int, int]]:
    """UDP sockets of this process: descriptor and inode."""
    inodes = {f"socket:[{port.inode}]": port.inode for port in udp_ports.read()}
    found = ((int(name), inodes.get(_link(name), 0)) for name in os.listdir("/proc/self/fd"))
    return frozenset((descriptor, inode) for descriptor, inode in found if inode)


def _link(descriptor: str) -> str:
    try:
        return os.readlink(f"/proc/self/fd/{descriptor}")
    except FileNotFoundError:
        return ""


class PeerFilter:
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
