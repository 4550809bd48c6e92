"""The vendor driver's topics on the node of ours: commands are taken under its names, and answered there.

What bathes keeps its own names; both may be used side by side, one motion at a time.
"""

import threading
from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.node.stage_node import StageNode
from bathbot_localize.messages import pose_from_transform
from geometry_msgs.msg import Pose
from rm_ros_interfaces.msg import Cartepos, Jointerrorcode, Jointpos, Movej, Movejp, Movel, Sixforce
from std_msgs.msg import Bool, UInt16

from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.rm65.driver import ArmDriver
from bathbot_scrub.rm65.ros.vendor.messages import (
    flange_from_message,
    joint_error_message,
    joints_from_message,
    share_from_message,
    sixforce_message,
)
from bathbot_scrub.rm65.timing.clock import MONOTONIC

_PREFIX = "rm_driver/"
_STATE = {
    "udp_arm_position": Pose,
    "udp_six_force": Sixforce,
    "udp_six_zero_force": Sixforce,
    "udp_joint_error_code": Jointerrorcode,
    "udp_arm_err": UInt16,
    "udp_sys_err": UInt16,
    "udp_arm_coordinate": UInt16,
}


class VendorTopics:
    """Subscriptions and publishers of one driver under the vendor's names."""

    def __init__(self, node: StageNode, driver: ArmDriver) -> None:
        """Create them on `node`, which owns them."""
        self._node, self._driver, moves = node, driver, driver.moves
        self._state = {name: node.publisher(kind, _PREFIX + name, 10) for name, kind in _STATE.items()}
        self._answer("movej", Movej, lambda m: moves.to_joints(joints_from_message(m.joint), _share(m)))
        self._answer("movej_p", Movejp, lambda m: moves.to_pose(flange_from_message(m.pose), _share(m)))
        self._answer("movel", Movel, lambda m: moves.along_line(flange_from_message(m.pose), _share(m)))
        self._answer("move_stop", Bool, lambda _: driver.stop())
        self._answer("clear_force_data", Bool, lambda _: driver.zero_force())
        self._take(
            "movej_canfd_cmd",
            Jointpos,
            lambda m: moves.stream(joints_from_message(m.joint), MONOTONIC()),
        )
        self._take(
            "movep_canfd_cmd",
            Cartepos,
            lambda m: moves.stream_pose(flange_from_message(m.pose), MONOTONIC()),
        )
        self._refused = ""

    def publish(self) -> None:
        """Send the newest state; call it at the rate wanted."""
        self._driver.moves.tick(MONOTONIC())
        sample = self._driver.link.sample
        if sample is None:
            return
        codes = [code & 0xFFFF for code in sample.errors]
        messages = {
            "udp_arm_position": pose_from_transform(sample.T_base_flange),
            "udp_six_force": sixforce_message(sample.raw_wrench),
            "udp_six_zero_force": sixforce_message(sample.wrench),
            "udp_joint_error_code": joint_error_message(sample.joint_errors),
            "udp_arm_err": UInt16(data=codes[0] if codes else 0),
            "udp_sys_err": UInt16(data=codes[1] if len(codes) > 1 else 0),
            "udp_arm_coordinate": UInt16(data=0),  # the sensor's axes
        }
        for name, message in messages.items():
            self._state[name].publish(message)

    def _answer(self, name: str, kind: type, call: Callable[[Any], Any]) -> None:
        """Take a command whose result is told when it has ended."""
        result = self._node.publisher(Bool, f"{_PREFIX}{name}_result", 10)

        def work(message: Any) -> None:
            result.publish(Bool(data=self._succeeds(name, lambda: call(message))))

        def begin(message: Any) -> None:
            threading.Thread(target=work, args=(message,), name=name, daemon=True).start()

        self._subscribe(f"{name}_cmd", kind, begin)

    def _take(self, name: str, kind: type, call: Callable[[Any], None]) -> None:
        """Take frames of a stream; nothing is answered."""
        self._subscribe(name, kind, lambda message: self._succeeds(name, lambda: call(message)))

    def _subscribe(self, name: str, kind: type, call: Callable[[Any], Any]) -> None:
        self._node.listen(kind, _PREFIX + name, call, 10)

    def _succeeds(self, name: str, call: Callable[[], Any]) -> bool:
        """Whether a call did what it should; each new reason is logged once."""
        try:
            call()
        except ArmError as error:
            if str(error) != self._refused:
                self._refused = str(error)
                self._node.get_logger().warning(f"{name}: {error}")
            return False
        self._refused = ""
        return True


def _share(message: Any) -> float:
    return share_from_message(message.speed, message.trajectory_connect)
