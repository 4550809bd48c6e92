"""How the processes of the graph exchange messages: the transports of Fast DDS.

Up to the reach `machine` all sockets are bound to loopback, none listens elsewhere or to multicast, and
participants find each other over loopback alone: shared memory can be opened from other network
namespaces, so it carries only what has been found.
"""

import os
import sys
from pathlib import Path

from bathbot_depthcorr.node.dds import reach
from bathbot_depthcorr.node.dds.reach import Reach

RANGE, PROFILES = "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"
PICTURES = str(Path(__file__).with_name("fastdds.xml"))  # shared memory with room for pictures
_UDP = str(Path(__file__).with_name("fastdds_udp.xml"))
_UNLESS_SET = {
    "AMENT_PREFIX_PATH": sys.prefix,
    # Synchronous publishing waits for slow readers with the interpreter's lock held: a busy recorder would
    # stall the control loop of the arm.
    "RMW_FASTRTPS_PUBLICATION_MODE": "ASYNCHRONOUS",
}
_SHUT = {"ROS_DISCOVERY_SERVER": "", "ROS_STATIC_PEERS": "", "ROS_LOCALHOST_ONLY": "0"}  # other ways to meet


def keep_clear_of_shared_memory() -> None:
    """Speak UDP only; for processes with a deadline, before their first node.

    A process of ordinary priority that is put aside while it holds a lock in shared memory makes the next
    one that publishes wait, with its interpreter's lock held: 0.1 s were seen on a busy machine.
    """
    if shares_memory():
        os.environ[PROFILES] = _UDP


def shares_memory() -> bool:
    """Whether this process lays what it publishes into shared memory."""
    return os.environ.get(PROFILES) == PICTURES


def variables() -> dict[str, str]:
    """The variables of ROS and Fast DDS to set before rclpy is imported, whatever the user has set them to.

    Only the reach `network` leaves the ways of discovery to the user.
    """
    chosen = {name: value for name, value in _UNLESS_SET.items() if name not in os.environ}
    if os.environ.get(reach.VARIABLE) == Reach.NETWORK:
        return chosen
    chosen |= {name: value for name, value in _SHUT.items() if name in os.environ}
    profile = _UDP if os.environ.get(PROFILES) == _UDP else PICTURES
    return chosen | {RANGE: "SYSTEM_DEFAULT", PROFILES: profile}  # that range is what the profile says
