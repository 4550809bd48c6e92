"""The operator of the fault matrix on the graph: asks for approaches, plays the planner, orders faults."""

from typing import Any

import numpy as np
from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.segment.messages import message_from_segment
from bathbot_scrub.segment.segment import Segment
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from bathbot_bringup.errors import StepError
from bathbot_bringup.evaluation.safety.trial.listener_node import ArmListener
from bathbot_bringup.evaluation.safety.trial_plan import REGION
from bathbot_bringup.graph.action_node import GraphAction
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.sim.arm.sim_client_node import SimClient
from bathbot_msgs.action import Approach, Scrub
from bathbot_msgs.msg import ScrubSegment

Array = NDArray[np.float64]
_SERVICES = ("stop", "resume", "retract", "home")
_ANSWER = 3.0  # [s]


class Operator:
    """Talks to the arm of one graph.

    Attributes:
        client: Has joined the graph.
        arm: What is heard of the arm.
        sim: Talks to the simulated arm.
    """

    def __init__(self, client: GraphClient) -> None:
        """Join a graph."""
        self.client, node = client, client.node
        self.arm = ArmListener(node)
        self.sim = SimClient(client)
        self._approach = GraphAction(client, Approach, "approach", _ANSWER)
        self._scrub = GraphAction(client, Scrub, "scrub", _ANSWER)
        for name in _SERVICES:
            client.service(Trigger, f"arm/{name}")
        self._segments = node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))

    def connect(self, timeout: float) -> None:
        """Wait until the driver hears its controller and everybody hears us.

        Raises:
            StepError: When that takes too long.
        """
        node = self.client.node

        def ready() -> bool:
            matched = self.sim.heard and node.count_subscribers("scrub_segments") > 1  # not only by us
            return matched and self.arm.connected and self._approach.offered

        if not self.client.spin_until(ready, timeout):
            raise StepError("connect", self.arm.reason if self.arm.reports else "rm65_driver says nothing")

    def forget(self) -> None:
        """Begin a trial: keep the newest report only, and have the trace begin anew."""
        self.arm.forget()
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
