"""What the driver is sent besides calls, segments and body clouds: read and planned beside the executor.

Whoever reads a message holds the interpreter's lock from its first byte to its last, 3 s for a segment of
200 000 poses. So what is larger than a segment or a cloud can be is refused unread.
"""

from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.long_work_node import outcome_of
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2

from bathbot_msgs.msg import ScrubSegment
from bathbot_scrub.rm65.driver import ArmDriver
from bathbot_scrub.rm65.ros.messages import body_from_cloud, checked_segment
from bathbot_scrub.rm65.ros.raw_listener_node import RawListener
from bathbot_scrub.segment.segment import MOST_POSES

_SEGMENT_SIZE = 56 * MOST_POSES + 4096  # [bytes] a pose takes 56
_CLOUD_SIZE = 1 << 20  # [bytes] 87 000 points
_AT_MOST = f"send {MOST_POSES} poses at most"
_COMPLAIN = 10.0  # [s] between two lines about clouds


class Intake:
    """Hears both for one driver.

    Attributes:
        refused: Why the newest segment was not taken; empty when it was.
    """

    def __init__(self, node: StageNode, driver: ArmDriver, warn: Callable[[str], None]) -> None:
        """Listen on `node`, which owns all of it; `warn` takes a line for the log."""
        self.refused = ""
        self._node, self._driver, self._warn = node, driver, warn
        RawListener(
            node, ScrubSegment, "scrub_segments", QoSProfile(depth=50), _SEGMENT_SIZE, self.follow,
            lambda size: self._refuse(f"a segment of {size} bytes was refused unread; {_AT_MOST}"),
        )  # fmt: skip
        RawListener(
            node, PointCloud2, "body_cloud", QoSProfile(depth=1), _CLOUD_SIZE, self.see,
            lambda size: self._complain(f"a body cloud of {size} bytes was refused unread; thin it out"),
        )  # fmt: skip

    def follow(self, raw: bytes) -> None:
        """Take a segment; it is planned before this returns."""
        outcome = outcome_of(self._node, lambda: self._begin_to_follow(raw))
        if isinstance(outcome, BathbotError):
            self._refuse(str(outcome))
        else:
            self.refused = ""

    def _begin_to_follow(self, raw: bytes) -> None:
        message = _read(raw, ScrubSegment, "a segment")
        try:
            self._driver.follow(checked_segment(message))
        except BathbotError as error:
            self._driver.refuse(message.path_id, message.index, str(error))  # it may be unreadable
            told = f"segment {message.index} of path {message.path_id} refused: {error}"
            raise BathbotError(told) from error

    def _refuse(self, why: str) -> None:
        self.refused = why
        self._warn(why)

    def see(self, raw: bytes) -> None:
        """Take a body cloud."""
        outcome = outcome_of(self._node, lambda: self._see(raw))
        if isinstance(outcome, BathbotError):
            self._complain(str(outcome))

    def _see(self, raw: bytes) -> None:
        cloud = _read(raw, PointCloud2, "a body cloud")
        self._driver.surroundings.see(*body_from_cloud(cloud, self._node.now()))

    def _complain(self, why: str) -> None:
        self._node.get_logger().warning(why, throttle_duration_sec=_COMPLAIN)


def _read(raw: bytes, message_type: type, what: str) -> Any:
    try:
        return deserialize_message(raw, message_type)
    except RuntimeError as error:
        raise BathbotError(f"{what} was refused that cannot be read: {error}") from error
