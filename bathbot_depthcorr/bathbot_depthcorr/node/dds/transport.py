"""How the processes of the graph find each other and exchange messages: the transports of Fast DDS.

Nothing leaves this machine unless the user asks for it with ROS's own variables.
"""

import os
import sys
from pathlib import Path

RANGE, PROFILES = "ROS_AUTOMATIC_DISCOVERY_RANGE", "FASTRTPS_DEFAULT_PROFILES_FILE"
LOCAL = "LOCALHOST"
PICTURES = str(Path(__file__).with_name("fastdds.xml"))  # shared memory with room for pictures
_UDP = str(Path(__file__).with_name("fastdds_udp.xml"))


def keep_clear_of_shared_memory() -> None:
    """Speak UDP only, where the user says nothing; for processes with a deadline, before their first node.

    A process of ordinary priority that is put aside while it holds a lock in shared memory makes the next
    one that publishes wait, with its interpreter's lock held: 0.1 s were seen on a busy machine. Within the
    range LOCALHOST ROS itself adds shared memory, so the profile says what that range would.
    """
    if os.environ.get(RANGE, LOCAL) == LOCAL and os.environ.get(PROFILES, PICTURES) == PICTURES:
        os.environ[RANGE], os.environ[PROFILES] = "SYSTEM_DEFAULT", _UDP


def defaults() -> dict[str, str]:
    """Variables that the user has not set, to be set before rclpy is imported."""
    chosen = {
        "AMENT_PREFIX_PATH": sys.prefix,
        RANGE: LOCAL,
        PROFILES: PICTURES,
        # Synchronous publishing waits for slow readers with the interpreter's lock held: a busy recorder
        # would stall the control loop of the arm.
        "RMW_FASTRTPS_PUBLICATION_MODE": "ASYNCHRONOUS",
    }
    return {name: value for name, value in chosen.items() if name not in os.environ}
