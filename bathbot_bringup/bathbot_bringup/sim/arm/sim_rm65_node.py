"""Node `sim_rm65`: the emulated RM65 controller beside the simulated person, and their true contact."""

import threading

import numpy as np
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import OK, StageNode
from bathbot_depthcorr.node.transport import keep_clear_of_shared_memory
from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.rm65.timing.beat import Ticker
from geometry_msgs.msg import Vector3
from std_msgs.msg import String

from bathbot_bringup.sim.arm.emulator.bathroom import bathroom_emulator, prefer_the_arm
from bathbot_bringup.sim.arm.emulator.node_settings import SimRm65Settings
from bathbot_bringup.sim.faults.faults import read_fault
from bathbot_msgs.msg import SimContact

_RATE = 50.0  # [Hz] of sim_contact
_REPORT_EVERY = 50  # messages


class SimRm65(StageNode):
    """Serves the vendor's protocol on TCP and UDP; publishes `sim_contact`."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("sim_rm65", SimRm65Settings)

    def setup(self, settings: SimRm65Settings) -> None:
        """Create the topic."""
        self._settings = settings
        self._contact = self.create_publisher(SimContact, "sim_contact", 10)
        self._requests = [
            self.create_subscription(String, "sim_fault", self._order, 10),
            self.create_subscription(String, "sim_trace", self._write_trace, 10),
        ]

    def start(self) -> None:
        """Open the ports."""
        self._emulator = bathroom_emulator(self._settings)
        self._count, self._pushed = 0, 0
        self._ticker = Ticker(_RATE, self._publish, self.get_logger().fatal)
        self.get_logger().info(
            f"RM65-{self._settings.variant} emulator listens on {self._settings.host}:{self._emulator.port}"
        )

    def stop(self) -> None:
        """Close the ports."""
        if hasattr(self, "_emulator"):
            self._ticker.close()
            self._emulator.close()
            if self._settings.trace:
                self._write(self._settings.trace)
            del self._emulator

    def teardown(self) -> None:
        """Let the topics go."""
        self.destroy_publisher(self._contact)
        for subscription in self._requests:
            self.destroy_subscription(subscription)

    def _order(self, message: String) -> None:
        """Let something fail."""
        try:
            self._emulator.order(read_fault(message.data))
        except (BathbotError, AttributeError) as error:
            self.get_logger().warning(f"sim_fault: {error}")

    def _write_trace(self, message: String) -> None:
        """Write the trace to a file beside the running timer; an empty name forgets it."""
        if not hasattr(self, "_emulator"):
            return
        if message.data:
            threading.Thread(target=self._write, args=(message.data,), daemon=True).start()
        else:
            self._emulator.trace.clear()

    def _write(self, path: str) -> None:
        try:
            self._emulator.trace.write(path)
        except BathbotError as error:
            self.get_logger().warning(f"sim_trace: {error}")

    def _publish(self) -> None:
        truth = self._emulator.truth()
        contact = truth.contact
        x, y, z = (float(v) for v in contact.force)
        message = SimContact(
            head=pose_from_transform(truth.T_base_head),
            compression=float(contact.compression),
            skin_indentation=float(contact.indentation),
            force=Vector3(x=x, y=y, z=z),
            part=contact.part,
        )
        message.header.stamp, message.header.frame_id = self.get_clock().now().to_msg(), "base_link"
        self._contact.publish(message)
        self._count += 1
        if self._count % _REPORT_EVERY == 0:
            pushed, self._pushed = self._emulator.pushed - self._pushed, self._emulator.pushed
            self.report(
                OK,
                "active",
                clients=len(self._emulator.sessions),
                refused=self._emulator.refused,
                pushed=pushed,
                late=self._emulator.late,
                force=f"{np.linalg.norm(contact.force):.2f}",
            )


def main() -> None:
    """Run the node."""
    prefer_the_arm()
    keep_clear_of_shared_memory()
    run(SimRm65)


if __name__ == "__main__":
    main()
