"""A filter in the kernel on a UDP socket: what does not come from given ports of 127.0.0.1 is dropped unread.

Classic BPF, as in linux/filter.h; for UDP the data begin with its header, and the IP header lies before it.
"""

import ctypes
import os
import socket
import struct
from collections.abc import Collection

_ATTACH = 26  # SO_ATTACH_FILTER
_LOAD_WORD, _LOAD_HALF, _JUMP, _JUMP_EQUAL, _RETURN = 0x20, 0x28, 0x05, 0x15, 0x06
_SOURCE_ADDRESS = (-0x100000 + 12) & 0xFFFFFFFF  # SKF_NET_OFF: in the IP header
_SOURCE_PORT = 0  # in the UDP header
_LOOPBACK = 0x7F000001
_ALL, _NOTHING = 0xFFFFFFFF, 0
_LONGEST = 4096  # instructions
_BLOCK = 254  # ports that share one instruction which lets pass: a jump passes over 255 at most

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, operand


def program(ports: Collection[int]) -> list[Instruction]:
    """Let pass what comes from one of these ports of 127.0.0.1; where they are too many, the lowest."""
    code: list[Instruction] = [
        (_LOAD_WORD, 0, 0, _SOURCE_ADDRESS),
        (_JUMP_EQUAL, 1, 0, _LOOPBACK),
        (_RETURN, 0, 0, _NOTHING),
        (_LOAD_HALF, 0, 0, _SOURCE_PORT),
    ]
    room = (_LONGEST - len(code)) // (_BLOCK + 2) * _BLOCK
    numbers = sorted(ports)[:room]
    for start in range(0, len(numbers), _BLOCK):
        block = numbers[start : start + _BLOCK]
        # Each jumps to the block's last instruction, which lets pass; the last one steps over it.
        code += [(_JUMP_EQUAL, len(block) - place, 0, port) for place, port in enumerate(block)]
        code += [(_JUMP, 0, 0, 1), (_RETURN, 0, 0, _ALL)]
    return [*code, (_RETURN, 0, 0, _NOTHING)]


def attach(descriptor: int, ports: Collection[int]) -> None:
    """Put the filter on a socket in place of the one it had.

    Raises:
        OSError: When it is no socket any more.
    """
    code = b"".join(struct.pack("=HBBI", *instruction) for instruction in program(ports))
    held = ctypes.create_string_buffer(code)
    value = struct.pack("@HP", len(code) // 8, ctypes.addressof(held))
    with socket.socket(fileno=os.dup(descriptor)) as udp:
        udp.setsockopt(socket.SOL_SOCKET, _ATTACH, value)
