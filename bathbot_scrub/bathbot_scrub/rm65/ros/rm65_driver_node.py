"""Node `rm65_driver`: the arm on the graph. Decodes, calls `ArmDriver`, encodes."""

import sys
import threading
from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from bathbot_depthcorr.node.transport import keep_clear_of_shared_memory
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState, ScrubSegment
from bathbot_scrub.rm65.arm.urdf import urdf
from bathbot_scrub.rm65.driver import ArmDriver, Snapshot
from bathbot_scrub.rm65.errors import ArmError, ArmSettingsError
from bathbot_scrub.rm65.motion.approach import Touch
from bathbot_scrub.rm65.ros.messages import (
    body_from_cloud,
    checked_segment,
    error_code,
    pose_stamped,
    request_from_goal,
)
from bathbot_scrub.rm65.ros.telemetry import Publishers, Telemetry, diagnostic_values, health
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.beat import Ticker
from bathbot_scrub.rm65.timing.priority import prefer_process


class Rm65Driver(StageNode):
    """Drives an RM65 by the vendor's protocol, real or emulated."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("rm65_driver", DriverSettings)

    def setup(self, settings: DriverSettings) -> None:
        """Create the topics."""
        self._settings, make = settings, self.create_publisher
        self._outputs = Publishers(
            joints=make(JointState, "joint_states", 10),
            wrench=make(WrenchStamped, "wrench", 10),
            filtered=make(WrenchStamped, "wrench_filtered", 10),
            pose=make(PoseStamped, "tool_pose", 10),
            tree=make(TFMessage, "/tf", 100),
            state=make(ArmState, "arm_state", 10),
        )
        self._description = make(String, "robot_description", LATCHED)
        self._description.publish(String(data=urdf(settings.variant)))

    def start(self) -> None:
        """Connect, and offer what the arm can do."""
        self._driver = driver = ArmDriver(self._settings, self._warn)
        self._telemetry, self._refused = Telemetry(driver, self._outputs), ""
        self.get_logger().info(f"control loop runs at {driver.loop.thread.priority}")
        calls = {
            "stop": driver.stop,
            "pause": driver.pause,
            "retract": driver.retract,
        }
        for name, call in calls.items():
            self.offer(f"arm/{name}", call)
        slow = {
            "home": driver.home,
            "resume": driver.resume,
            "zero_force": lambda: f"{driver.zero_force():.2f} N remain",
        }
        for name, call in slow.items():
            self.offer_beside(f"arm/{name}", call)
        self._segments = self.create_subscription(
            ScrubSegment, "scrub_segments", self._follow, QoSProfile(depth=50)
        )
        self._body = self.create_subscription(PointCloud2, "body_cloud", self._see_body, 1)
        self._outcomes: dict[bytes, Touch | ArmError] = {}  # of approaches that have ended, by their id
        self._action = ActionServer(
            self,
            Approach,
            "approach",
            self._conclude,
            handle_accepted_callback=self._begin_approach,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self._vendor = vendor_topics(self, driver) if self._settings.vendor_topics else None
        self._ticker = Ticker(self._settings.publish_rate, self._publish, self.get_logger().fatal)

    def stop(self) -> None:
        """Stop the arm and let go of it."""
        if hasattr(self, "_ticker"):
            self._ticker.close()
            self._driver.close()
            if self._vendor is not None:
                self._vendor.close()
            self.destroy_subscription(self._segments)
            self.destroy_subscription(self._body)
            self._action.destroy()
            del self._ticker

    def teardown(self) -> None:
        """Let the topics go."""
        for publisher in (*self._outputs, self._description):
            self.destroy_publisher(publisher)

    def _warn(self, line: str) -> None:
        self.get_logger().warning(line)

    def _follow(self, message: ScrubSegment) -> None:
        outcome = self._outcome(lambda: self._driver.follow(checked_segment(message)))
        self._refused = ""
        if isinstance(outcome, ArmError):
            self._refused = f"segment {message.index} of path {message.path_id} refused: {outcome}"
            self._warn(self._refused)

    def _see_body(self, message: PointCloud2) -> None:
        now = self.get_clock().now().nanoseconds * 1e-9
        outcome = self._outcome(lambda: self._driver.surroundings.see(*body_from_cloud(message, now)))
        if isinstance(outcome, ArmError):
            self.get_logger().warning(str(outcome), throttle_duration_sec=10.0)

    def _begin_approach(self, goal: ServerGoalHandle) -> None:
        """Approach in a thread of its own and execute the goal with the outcome: executors must not wait."""

        def tell(remaining: float, force: float) -> None:
            goal.publish_feedback(Approach.Feedback(remaining=remaining, force=force))

        def work() -> None:
            outcome = self._outcome(
                lambda: self._driver.approach(
                    request_from_goal(goal.request), lambda: goal.is_cancel_requested, tell
                )
            )
            self._outcomes[bytes(goal.goal_id.uuid)] = outcome
            goal.execute()

        threading.Thread(target=work, name="approach", daemon=True).start()

    def _conclude(self, goal: ServerGoalHandle) -> Approach.Result:
        outcome = self._outcomes.pop(bytes(goal.goal_id.uuid))
        if isinstance(outcome, ArmError):
            self._warn(f"approach: {outcome}")
            goal.canceled() if goal.is_cancel_requested else goal.abort()
            return Approach.Result(error_code=error_code(outcome), error_msg=str(outcome))
        goal.succeed()
        contact = pose_stamped(outcome.T_base_head, self.get_clock().now().to_msg())
        return Approach.Result(contact=contact, force=outcome.force)

    def _outcome(self, call: Callable[[], Any]) -> Any:
        """Result of a call, or its ArmError."""
        try:
            return call()
        except ArmError as error:
            return error
        except Exception as error:  # in a thread nobody would see it
            self.get_logger().fatal(f"{type(error).__name__}: {error}")
            return ArmError(f"{type(error).__name__}: {error}")

    def _publish(self) -> None:
        if self._vendor is not None:
            self._vendor.publish()
        snapshot = self._telemetry.publish(self.get_clock().now().to_msg())
        if snapshot is not None:
            self._report(snapshot)

    def _report(self, snapshot: Snapshot) -> None:
        found = health(self._driver, snapshot, self._refused)
        level = ERROR if not found.sound else WARN if found.doubtful else OK
        self.report(level, found.message, **diagnostic_values(self._driver, snapshot))


def vendor_topics(node: Rm65Driver, driver: ArmDriver) -> Any:
    """The vendor driver's topics on `node`.

    Raises:
        ArmSettingsError: Its messages are not installed.
    """
    try:
        from bathbot_scrub.rm65.ros.vendor.vendor_topics_node import VendorTopics
    except ModuleNotFoundError as error:
        raise ArmSettingsError(
            f"vendor_topics is true, but there is no module {error.name}; build rm_ros_interfaces of the "
            "vendor's ros2_rm_robot and source it"
        ) from error
    return VendorTopics(node, driver)


def main() -> None:
    """Run the node."""
    sys.setswitchinterval(0.0005)  # the control loop shares the interpreter with the executor
    prefer_process()
    keep_clear_of_shared_memory()
    run(Rm65Driver)


if __name__ == "__main__":
    main()
