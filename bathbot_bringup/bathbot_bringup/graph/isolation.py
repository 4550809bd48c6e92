"""A DDS domain that nobody on this machine uses, so that two demos never hear each other."""

from collections.abc import Collection
from pathlib import Path

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
