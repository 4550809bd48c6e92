"""Plays camera, detector and localiser for the real planner: one target, and the skin about it."""

import time
from types import TracebackType

import numpy as np
from bathbot_localize.messages import cloud_from_surface, pose_from_transform
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from bathbot_bringup.evaluation.safety.trial_plan import REGION
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_msgs.msg import ContactTarget, ContactTargets

Array = NDArray[np.float64]
_PERIOD = 0.1  # [s] between pictures


class FakeLocalizer:
    """Publishes `contact_targets` and `surface` whenever the client spins; a context manager."""

    def __init__(self, client: GraphClient, skin: Array, T_base_target: Array) -> None:
        """Begin to see.

        Args:
            client: Of the graph.
            skin: Organised points in the base frame [m], shape (H, W, 3).
            T_base_target: Contact target, z into the skin, (4, 4).
        """
        self._node, self._skin, self._target = client.node, skin, T_base_target
        self._offset, self._sees = np.zeros(3), True
        self._surface = self._node.create_publisher(PointCloud2, "surface", 5)
        self._targets = self._node.create_publisher(ContactTargets, "contact_targets", 10)
        self._timer = self._node.create_timer(_PERIOD, self._look)

    def move(self, distance: float) -> float:
        """See the skin farther away from now on [m]; gives the time of the first such picture [s]."""
        self._offset = distance * self._target[:3, 2]
        stamp = time.monotonic()
        self._look()
        return stamp

    def lose(self) -> float:
        """See nothing any more; gives the time [s]."""
        self._sees = False
        return time.monotonic()

    def __enter__(self) -> "FakeLocalizer":
        """Look."""
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Leave the graph."""
        self._node.destroy_timer(self._timer)
        for publisher in (self._surface, self._targets):
            self._node.destroy_publisher(publisher)

    def _look(self) -> None:
        if not self._sees:
            return
        header = Header(frame_id="base_link", stamp=self._node.get_clock().now().to_msg())
        self._surface.publish(cloud_from_surface(self._skin + self._offset, header))
        found = ContactTarget(region=REGION, score=0.9)
        found.pose.pose = pose_from_transform(self._target)
        self._targets.publish(ContactTargets(header=header, targets=[found]))
