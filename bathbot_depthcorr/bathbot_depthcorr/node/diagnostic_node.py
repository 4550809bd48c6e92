"""How a node is: its status on /diagnostics."""

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
_STATUS_PERIOD = 1.0  # [s]


class Diagnostic:
    """Sends the status of one node every second, and at once when level or message change.

    Attributes:
        status: What is sent.
    """

    def __init__(self, node: Node, message: str) -> None:
        """Begin with a warning."""
        name, self._node = node.get_name(), node
        self.status = DiagnosticStatus(name=name, hardware_id=name, level=WARN, message=message)
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        node.create_timer(_STATUS_PERIOD, self._publish)

    def report(self, level: bytes, message: str, **values: Any) -> None:
        """Set level, message and values."""
        changed = (level, message) != (self.status.level, self.status.message)
        self.status.level, self.status.message = level, message
        self.status.values = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        if changed:
            self._publish()

    def _publish(self) -> None:
        message = DiagnosticArray(status=[self.status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
