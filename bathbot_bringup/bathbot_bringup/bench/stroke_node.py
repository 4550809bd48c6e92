"""Washes the planner's path to and fro, for as long as the bench needs the arm to stream."""

import copy

from bathbot_scrub.arm.states import State
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile

from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.msg import ArmState, ScrubSegment

_AHEAD = 3  # segments with the arm, as scrub_planner keeps them


class StrokeRepeater:
    """Hears the segments of the planner and, when its path is done, sends them again, backwards and forwards.

    Attributes:
        diagnostics: Newest values of each node's diagnostic, by node and name.
    """

    def __init__(self, client: GraphClient) -> None:
        """Listen on a graph."""
        self._client, node = client, client.node
        self._heard: list[ScrubSegment] = []
        self._path: list[ScrubSegment] = []  # being sent
        self._sent = 0
        self._arm = ArmState()
        self.diagnostics: dict[str, dict[str, str]] = {}
        self._segments = node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        node.create_subscription(ScrubSegment, "scrub_segments", self._on_segment, QoSProfile(depth=50))
        node.create_subscription(ArmState, "arm_state", self._on_arm, 10)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 50)

    def step(self) -> None:
        """Send what is due.

        Raises:
            StepError: When the arm has left the skin.
        """
        if self._arm.state != State.CONTACT:
            raise StepError("bench", f"the arm is in {State(self._arm.state).name}: {self._arm.reason}")
        if not self._path:
            self._turn(self._heard)
        elif self._arm.path_id == self._path[0].path_id and self._arm.path_done:
            self._turn(self._path)
        mine = self._arm.path_id == self._path[0].path_id
        reached = self._arm.segment_index if mine else 0
        if self._sent < len(self._path) and self._sent - reached < _AHEAD:
            self._segments.publish(self._path[self._sent])
            self._sent += 1

    def _turn(self, path: list[ScrubSegment]) -> None:
        """Make a path, turned about, the next one."""
        if not path or not path[-1].last:
            raise StepError("bench", "the planner's path was not heard to its end")
        turned_path = []
        for index, segment in enumerate(reversed(path)):
            turned = copy.copy(segment)
            turned.path_id, turned.index = (segment.path_id + 1) % 2**32, index
            turned.last = index == len(path) - 1
            turned.poses = list(reversed(segment.poses))
            turned_path.append(turned)
        self._path, self._sent = turned_path, 0

    def _on_segment(self, message: ScrubSegment) -> None:
        if not self._path:
            self._heard.append(message)

    def _on_arm(self, message: ArmState) -> None:
        self._arm = message

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.diagnostics.setdefault(status.name, {}).update(
                {pair.key: pair.value for pair in status.values}
            )
