"""What the operator of the fault matrix hears of the arm: its reports, its head, its joints, its path."""

import time

import numpy as np
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from bathbot_bringup.evaluation.safety.measures import Report
from bathbot_bringup.evaluation.safety.trial.stroke_player import LastPose, Progress
from bathbot_msgs.msg import ArmState, ScrubSegment

Array = NDArray[np.float64]


class ArmListener:
    """Hears the arm of one graph.

    Attributes:
        reports: What the driver said, since `forget`.
        progress: How far it is along its path; None before the first report.
        head: Newest position of the head [m], shape (3,), and when it was heard [s].
        last_pose: End of the newest good segment on the topic, whoever sent it; None before the first.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe."""
        self.reports: list[Report] = []
        self.progress: Progress | None = None
        self.head: tuple[Array, float] = (np.full(3, np.nan), 0.0)
        self.last_pose: LastPose | None = None
        self._joints: tuple[Array, Array] = (np.zeros(6), np.zeros(6))  # [rad], the newest two
        node.create_subscription(ArmState, "arm_state", self._on_arm, 50)
        node.create_subscription(PoseStamped, "tool_pose", self._on_pose, 10)
        node.create_subscription(JointState, "joint_states", self._on_joints, 10)
        node.create_subscription(ScrubSegment, "scrub_segments", self._on_segment, QoSProfile(depth=50))

    @property
    def connected(self) -> bool:
        """Whether the driver hears its controller, as last told."""
        return bool(self.reports) and self.reports[-1].connected

    @property
    def state(self) -> int:
        """State of the arm, as last told."""
        return self.reports[-1].state if self.reports else -1

    @property
    def reason(self) -> str:
        """What the driver last said of it; empty before the first report."""
        return self.reports[-1].reason if self.reports else ""

    def fastest_joint(self) -> int:
        """Which joint moves fastest just now, 1..6."""
        before, now = self._joints
        return int(np.abs(now - before).argmax()) + 1

    def forget(self) -> None:
        """Keep the newest report only."""
        del self.reports[:-1]
        self.last_pose = None

    def _on_arm(self, message: ArmState) -> None:
        self.reports.append(Report(time.monotonic(), message.state, message.reason, message.connected))
        self.progress = Progress(message.path_id, message.segment_index, message.path_done)

    def _on_pose(self, message: PoseStamped) -> None:
        place = message.pose.position
        self.head = np.array([place.x, place.y, place.z]), time.monotonic()

    def _on_joints(self, message: JointState) -> None:
        self._joints = self._joints[1], np.asarray(message.position, dtype=float)

    def _on_segment(self, message: ScrubSegment) -> None:
        place = message.poses[-1].position
        position = np.array([place.x, place.y, place.z])
        if np.isfinite(position).all():
            self.last_pose = LastPose(time.monotonic(), position, message.path_id)
