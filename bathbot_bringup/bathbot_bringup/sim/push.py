"""The UDP state push of the emulated controller: settings, datagram, sending."""

import json
import socket
from dataclasses import dataclass

import numpy as np
from bathbot_scrub.rm65.protocol import (
    euler_from_rotation,
    joints_to_wire,
    quaternion_to_wire,
    wrench_to_wire,
)

from bathbot_bringup.sim.controller import Controller

_SPEED_UNIT = np.radians(0.01)  # 0.01 deg/s; the documents disagree with 0.01 RPM
_CURRENT = [350] * 6  # healthy joints, all of them
_VOLTAGE = [24000] * 6
_TEMPERATURE = [34000] * 6


@dataclass(frozen=True, slots=True)
class PushSettings:
    """What set_realtime_push says."""

    enable: bool = True
    cycle: int = 1  # in steps of 5 ms
    port: int = 8089
    ip: str = "127.0.0.1"
    force_coordinate: int = 0  # 0 sensor, 1 work, 2 tool frame


def datagram(controller: Controller, push: PushSettings) -> bytes:
    """Write the present state as the controller does."""
    reading, T = controller.sensor.reading, controller.T_base_flange
    zero = reading.zero
    if push.force_coordinate == 1:
        zero = np.concatenate([T[:3, :3] @ zero[:3], T[:3, :3] @ zero[3:]])
    error = controller.error
    return (
        json.dumps(
            {
                "state": "realtime_arm_joint_state",
                "arm_current_status": controller.motion.value,
                "err": [error],
                "arm_err": error,
                "sys_err": 0,
                "joint_status": {
                    "joint_position": joints_to_wire(controller.dynamics.positions),
                    "joint_speed": [round(v / _SPEED_UNIT) for v in controller.dynamics.speeds],
                    "joint_current": _CURRENT,
                    "joint_voltage": _VOLTAGE,
                    "joint_temperature": _TEMPERATURE,
                    "joint_en_flag": [1] * 6,
                    "joint_err_code": [0] * 6,
                },
                "six_force_sensor": {
                    "force": wrench_to_wire(reading.raw),
                    "zero_force": wrench_to_wire(zero),
                    "coordinate": push.force_coordinate,
                },
                "waypoint": {
                    "position": [round(float(x) * 1e6) for x in T[:3, 3]],
                    "euler": [round(float(a) * 1e3) for a in euler_from_rotation(T[:3, :3])],
                    "quat": quaternion_to_wire(T[:3, :3]),
                },
            },
            separators=(",", ":"),
        ).encode()
        + b"\r\n"
    )


class PushSender:
    """Sends datagrams where the settings say; a dead receiver is no error."""

    def __init__(self) -> None:
        """Open a socket."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self.sent = 0
        self.failed = 0

    def send(self, data: bytes, push: PushSettings) -> None:
        """Send one datagram; failures are counted."""
        try:
            self._socket.sendto(data, (push.ip, push.port))
            self.sent += 1
        except (OSError, UnicodeError):
            self.failed += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
