"""The UDP state push of the emulated controller: settings, datagram, sending."""

import json
import math
import socket
from dataclasses import dataclass

import numpy as np
from bathbot_scrub.rm65.controller.protocol import (
    joints_to_wire,
    pose_to_wire,
    quaternion_to_wire,
    wrench_to_wire,
)
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.arm.controller.controller import Controller
from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.push_faults import Datagram, Outbox

Array = NDArray[np.float64]
CURRENT = [350] * 6  # [0.001 A]
VOLTAGE = [24000] * 6  # [0.001 V]
TEMPERATURE = [34000] * 6  # [0.001 deg C]
_SPEED_UNIT = np.radians(0.01)  # 0.01 deg/s; the documents disagree with 0.01 RPM
BLOCKS = (
    "joint_speed", "arm_current_status", "lift_state", "expand_state", "hand_state", "aloha_state",
    "plus_base", "plus_state",
)  # fmt: skip
"""Parts that may be switched on; of devices that this arm does not have nothing is sent."""


@dataclass(frozen=True, slots=True)
class PushSettings:
    """What set_realtime_push says."""

    enable: bool = True
    cycle: int = 1  # in steps of 5 ms
    port: int = 8089
    ip: str = ""  # empty: to whoever came last by TCP
    force_coordinate: int = 0  # 0 sensor, 1 work, 2 tool frame
    blocks: frozenset[str] = frozenset({"joint_speed", "arm_current_status"})


def in_work_frame(controller: Controller, wrench: Array) -> Array:
    """A wrench of the sensor frame, shape (6,), in axes of the work frame."""
    return _turned(controller.setup.works.T[:3, :3].T @ controller.T_base_flange[:3, :3], wrench)


def in_tool_frame(controller: Controller, wrench: Array) -> Array:
    """A wrench of the sensor frame, shape (6,), in axes of the tool frame."""
    return _turned(controller.setup.tools.T[:3, :3].T, wrench)


def _turned(rotation: Array, wrench: Array) -> Array:
    return np.concatenate([rotation @ wrench[:3], rotation @ wrench[3:]])


def wire_wrench(wrench: ArrayLike) -> list[int | None]:
    """Forces and torques [N, Nm] on the wire; what is no number is null, as the usual C library writes it."""
    wrench = np.asarray(wrench)
    return wrench_to_wire(wrench) if np.isfinite(wrench).all() else [None] * len(wrench)


def datagram(controller: Controller, push: PushSettings) -> Datagram:
    """Write the present state as the controller does."""
    reading, dynamics, error = controller.sensor.reading, controller.dynamics, controller.health.error
    zero = reading.zero
    if push.force_coordinate == 1:
        zero = in_work_frame(controller, zero)
    elif push.force_coordinate == 2:
        zero = in_tool_frame(controller, zero)
    joints = {"joint_position": joints_to_wire(dynamics.positions)}
    if "joint_speed" in push.blocks:
        joints["joint_speed"] = [round(v / _SPEED_UNIT) for v in dynamics.speeds]
    state = {
        "state": "realtime_arm_joint_state",
        "err": [error],
        "arm_err": error,
        "sys_err": controller.system_error,
        "joint_status": {
            **joints,
            "joint_current": CURRENT,
            "joint_voltage": VOLTAGE,
            "joint_temperature": TEMPERATURE,
            "joint_en_flag": controller.health.joints_on,
            "joint_err_code": controller.health.joint_codes,
        },
        "six_force_sensor": {
            "force": wire_wrench(reading.raw),
            "zero_force": wire_wrench(zero),
            "coordinate": push.force_coordinate,
        },
        "waypoint": _waypoint(controller.setup.tool_pose(controller.T_base_flange)),
    }
    if "arm_current_status" in push.blocks:
        state["arm_current_status"] = controller.motion.value
    data = json.dumps(state, separators=(",", ":")).encode() + b"\r\n"
    return Datagram(data, float(np.linalg.norm(zero[:3])))


def _waypoint(T_work_tool: Array) -> dict[str, list[int]]:
    """Pose of the tool, (4, 4), in the units of the push."""
    place = pose_to_wire(T_work_tool)
    return {"position": place[:3], "euler": place[3:], "quat": quaternion_to_wire(T_work_tool[:3, :3])}


class PushSender:
    """Sends datagrams where the settings say; a dead receiver is no error.

    The faults of the push happen here.
    """

    def __init__(self, faults: FaultSchedule | None = None) -> None:
        """Open a socket."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._faults, self._outbox = faults or FaultSchedule(), Outbox()
        self.sent = 0
        self.failed = 0

    def send(self, state: Datagram, address: tuple[str, int], now: float) -> float:
        """Send one datagram, or do with it what the faults demand; `now` in [s].

        Returns the force of the newest datagram that left [N], NaN when none did. Failures are counted.
        """
        leaving = self._outbox.leaving(state, now, self._faults.at(Place.PUSH))
        for one in leaving:
            self._send(one.data, address)
        return leaving[-1].force if leaving else math.nan

    def _send(self, data: bytes, address: tuple[str, int]) -> None:
        try:
            self._socket.sendto(data, address)
            self.sent += 1
        except (OSError, UnicodeError):
            self.failed += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
