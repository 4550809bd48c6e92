"""Whose the UDP ports of this machine are: what the kernel tells in `/proc/net/udp`. Pure but for `read`."""

from collections.abc import Collection, Iterable
from pathlib import Path
from typing import NamedTuple

LOOPBACK, ANY = "7f000001", "00000000"  # addresses as hexadecimal numbers
_ANY_V6 = "0" * 32
_TABLES = (Path("/proc/net/udp"), Path("/proc/net/udp6"))


def of_domain(domain: int) -> range:
    """The ports on which the participants of a DDS domain listen, by the RTPS rule."""
    return range(7400 + 250 * domain, 7400 + 250 * (domain + 1))


class Port(NamedTuple):
    """One bound UDP socket."""

    address: str  # hexadecimal, in the order it is written; `ANY` for all
    number: int
    owner: int  # user id
    inode: int  # of the socket


def parse(table: str) -> list[Port]:
    """Read the text of `/proc/net/udp` or `/proc/net/udp6`."""
    return [_port(row.split()) for row in table.splitlines()[1:] if row.strip()]


def _port(row: list[str]) -> Port:
    address, _, number = row[1].rpartition(":")
    if address == _ANY_V6:
        address = ANY  # hears and sends IPv4, too
    elif len(address) == len(LOOPBACK):
        address = bytes.fromhex(address)[::-1].hex()  # the kernel writes it as this machine stores it
    return Port(address, int(number, 16), int(row[7]), int(row[9]))


def read() -> list[Port]:
    """All UDP sockets of this network namespace."""
    return [port for table in _TABLES if table.is_file() for port in parse(table.read_text("ascii"))]


def trusted(ports: Iterable[Port], users: Collection[int]) -> frozenset[int]:
    """Numbers from which only these users can send over 127.0.0.1.

    A number that somebody else holds, too, is nobody's: two sockets may share one where both ask for it.
    """
    near = [port for port in ports if port.address in (LOOPBACK, ANY)]
    strange = {port.number for port in near if port.owner not in users}
    return frozenset(port.number for port in near) - strange
