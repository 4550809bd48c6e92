"""Domains and ports that nobody on this machine uses, so that two demos never hear each other."""

import socket
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

DOMAINS = range(1, 101)


def domain_ports(domain: int) -> range:
    """Give the UDP ports on which the participants of a domain listen, by the RTPS rule."""
    return range(7400 + 250 * domain, 7400 + 250 * (domain + 1))


def used_ports() -> set[int]:
    """List the UDP ports bound on this machine; empty where the kernel does not tell."""
    ports: set[int] = set()
    for table in (Path("/proc/net/udp"), Path("/proc/net/udp6")):
        if table.is_file():
            rows = table.read_text(encoding="ascii").splitlines()[1:]
            ports |= {int(row.split()[1].rpartition(":")[2], 16) for row in rows}
    return ports


def free_domain(wish: int, taken: Collection[int]) -> int:
    """Choose a domain with no participant.

    Args:
        wish: Any number, such as a process id; the search starts from it.
        taken: UDP ports in use.

    Returns:
        A domain in 1..100; the wished one when all are in use.
    """
    start = wish % len(DOMAINS)
    for domain in (*DOMAINS[start:], *DOMAINS[:start]):
        if not any(port in taken for port in domain_ports(domain)):
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
