"""Domains and ports that nobody on this machine uses, so that two demos never hear each other."""

import socket
from collections.abc import Collection
from typing import NamedTuple

from bathbot_depthcorr.node.dds import shared_memory, udp_ports

DOMAINS = range(1, 101)


def used_ports() -> set[int]:
    """Ports of this machine that somebody holds: over UDP, and other users in shared memory."""
    return {port.number for port in udp_ports.read()} | set(shared_memory.foreign_ports())


def free_domain(wish: int, taken: Collection[int]) -> int:
    """Choose a domain with no participant.

    Args:
        wish: Any number, such as a process id; the search starts from it.
        taken: Ports in use.

    Returns:
        A domain in 1..100; the wished one when all are in use.
    """
    start = wish % len(DOMAINS)
    for domain in (*DOMAINS[start:], *DOMAINS[:start]):
        if not any(port in taken for port in udp_ports.of_domain(domain)):
            return domain
    return DOMAINS[start]


class Ports(NamedTuple):
    """Ports between the driver and the simulated controller, on loopback."""

    tcp: int
    udp: int


def free_ports() -> Ports:
    """Ask the system for two ports that nobody uses."""
    with socket.socket() as tcp, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        tcp.bind(("127.0.0.1", 0))
        udp.bind(("127.0.0.1", 0))
        return Ports(tcp.getsockname()[1], udp.getsockname()[1])
