"""The operator of the fault matrix on the graph: asks for approaches, plays the planner, orders faults."""

import time
from typing import Any

import numpy as np
from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.segment.messages import message_from_segment
from bathbot_scrub.segment.segment import Segment
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from bathbot_bringup.errors import StepError
from bathbot_bringup.evaluation.safety.measures import Report
from bathbot_bringup.evaluation.safety.trial.stroke_player import LastPose, Progress
from bathbot_bringup.evaluation.safety.trial_plan import REGION
from bathbot_bringup.graph.action_node import GraphAction
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.sim.arm.sim_client_node import SimClient
from bathbot_msgs.action import Approach, Scrub
from bathbot_msgs.msg import ArmState, ScrubSegment

Array = NDArray[np.float64]
_SERVICES = ("stop", "resume", "retract", "home")
_ANSWER = 3.0  # [s]


class Operator:
    """Talks to the arm of one graph.

    Attributes:
        sim: Talks to the simulated arm.
        reports: What the driver said, since `forget`.
        head: Newest position of the head [m], shape (3,), and when it was heard [s].
        last_pose: End of the newest good segment on the topic, whoever sent it; None before the first.
    """

    def __init__(self, client: GraphClient) -> None:
        """Join a graph."""
        self.client, node = client, client.node
        self.reports: list[Report] = []
        self.progress: Progress | None = None
        self.head: tuple[Array, float] = (np.full(3, np.nan), 0.0)
        self.last_pose: LastPose | None = None
        self._joints: tuple[Array, Array] = (np.zeros(6), np.zeros(6))  # [rad], the newest two
        self.sim = SimClient(client)
        self._approach = GraphAction(client, Approach, "approach", _ANSWER)
        self._scrub = GraphAction(client, Scrub, "scrub", _ANSWER)
        for name in _SERVICES:
            client.service(Trigger, f"arm/{name}")
        self._segments = node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        node.create_subscription(ArmState, "arm_state", self._on_arm, 50)
        node.create_subscription(PoseStamped, "tool_pose", self._on_pose, 10)
        node.create_subscription(JointState, "joint_states", self._on_joints, 10)
        node.create_subscription(ScrubSegment, "scrub_segments", self._on_segment, QoSProfile(depth=50))

    def connect(self, timeout: float) -> None:
        """Wait until the driver hears its controller and everybody hears us.

        Raises:
            StepError: When that takes too long.
        """
        node = self.client.node

        def ready() -> bool:
            matched = self.sim.heard and node.count_subscribers("scrub_segments") > 1  # not only by us
            connected = bool(self.reports) and self.reports[-1].connected
            return matched and connected and self._approach.offered

        if not self.client.spin_until(ready, timeout):
            raise StepError(
                "connect", self.reports[-1].reason if self.reports else "rm65_driver says nothing"
            )

    @property
    def state(self) -> int:
        """State of the arm, as last told."""
        return self.reports[-1].state if self.reports else -1

    def fastest_joint(self) -> int:
        """Which joint moves fastest just now, 1..6."""
        before, now = self._joints
        return int(np.abs(now - before).argmax()) + 1

    def forget(self) -> None:
        """Begin a trial: keep the newest report only, and have the trace begin anew."""
        del self.reports[:-1]
        self.last_pose = None
        self.sim.begin_trace()

    def approach(self, T_base_target: Array, standoff: float) -> Any:
        """Send the goal; gives the future of its result.

        Raises:
            StepError: When nobody takes it.
        """
        goal = Approach.Goal(region=REGION, standoff=standoff)
        goal.target.header.frame_id = "base_link"
        goal.target.header.stamp = self.client.node.get_clock().now().to_msg()
        goal.target.pose = pose_from_transform(T_base_target)
        return self._approach.send("approach", goal).get_result_async()

    def planners(self) -> int:
        """How many nodes may send segments, this one included."""
        return self.client.node.count_publishers("scrub_segments")

    def scrub(self) -> None:
        """Have the real planner scrub from where the arm is in contact.

        Raises:
            StepError: When nobody takes the goal.
        """
        self._scrub.send("scrub", Scrub.Goal(region=REGION))

    def ask(self, name: str) -> str:
        """Call a service of the arm; gives the reason when it refuses, empty when it does it."""
        try:
            self.client.trigger(name, f"arm/{name}", _ANSWER)
        except StepError as error:
            return str(error)
        return ""

    def send(self, segment: Segment) -> None:
        """Publish a segment."""
        now = self.client.node.get_clock().now().nanoseconds * 1e-9
        self._segments.publish(message_from_segment(segment._replace(stamp=now)))

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
