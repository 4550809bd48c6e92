"""Node `sim_rm65`: the emulated RM65 controller beside the simulated person, and their true contact."""

import threading
from functools import partial

import numpy as np
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.dds.transport import keep_clear_of_shared_memory
from bathbot_depthcorr.node.endpoints_node import guarded
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import OK, StageNode
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
        self._contact = self.publisher(SimContact, "sim_contact", 10)

    def start(self) -> None:
        """Open the ports."""
        self._emulator = bathroom_emulator(self._settings)
        self._count, self._pushed = 0, 0
        self.at_end(self._close)
        self.hold(Ticker(_RATE, self._publish, self.get_logger().fatal))
        self.listen(String, "sim_fault", guarded(self._order, partial(self._refuse, "sim_fault")), 10)
        self.listen(String, "sim_trace", self._write_trace, 10)
        self.get_logger().info(
            f"RM65-{self._settings.variant} emulator listens on {self._settings.host}:{self._emulator.port}"
        )

    def _close(self) -> None:
        self._emulator.close()
        if self._settings.trace:
            self._write(self._settings.trace)

    def _order(self, message: String) -> None:
        """Let something fail."""
        self._emulator.order(read_fault(message.data))

    def _write_trace(self, message: String) -> None:
        """Write the trace to a file beside the running timer; an empty name forgets it."""
        if message.data:
            threading.Thread(target=self._write, args=(message.data,), daemon=True).start()
        else:
            self._emulator.trace.clear()

    def _write(self, path: str) -> None:
        try:
            self._emulator.trace.write(path)
        except BathbotError as error:
            self._refuse("sim_trace", error)

    def _refuse(self, topic: str, error: Exception) -> None:
        self.get_logger().warning(f"{topic}: {error}")

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
    run(SimRm65, "--disable-external-lib-logs")  # as for the driver: the push must not wait for a disk


if __name__ == "__main__":
    main()
