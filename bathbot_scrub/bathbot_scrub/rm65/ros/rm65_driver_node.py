"""Node `rm65_driver`: the arm on the graph. Decodes, calls `ArmDriver`, encodes."""

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.dds.transport import keep_clear_of_shared_memory
from bathbot_depthcorr.node.long_work_node import outcome_of
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.driver import rm65_driver
from bathbot_scrub.rm65.motion.approach import Touch
from bathbot_scrub.rm65.ros.intake_node import Intake
from bathbot_scrub.rm65.ros.messages import (
    approach_result,
    request_from_goal,
)
from bathbot_scrub.rm65.ros.telemetry import Publishers, Telemetry, diagnostic_values, health
from bathbot_scrub.rm65.ros.vendor.installed import vendor_topics
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.beat import Ticker
from bathbot_scrub.rm65.timing.priority import prefer_process

_LINES = 200  # of the log that may wait; the newest are kept
_LAST_WORDS = 0.5  # [s] for those that wait at the end


class Rm65Driver(StageNode):
    """Drives an RM65 by the vendor's protocol, real or emulated."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("rm65_driver", DriverSettings)

    def setup(self, settings: DriverSettings) -> None:
        """Create the topics."""
        self._settings, make = settings, self.publisher
        self._outputs = Publishers(
            joints=make(JointState, "joint_states", 10),
            wrench=make(WrenchStamped, "wrench", 10),
            filtered=make(WrenchStamped, "wrench_filtered", 10),
            pose=make(PoseStamped, "tool_pose", 10),
            tree=make(TFMessage, "/tf", 100),
            state=make(ArmState, "arm_state", 10),
        )
        make(String, "robot_description", LATCHED).publish(String(data=RM65(settings.variant).description()))

    def start(self) -> None:
        """Connect, and offer what the arm can do."""
        self._lines = self.worker(self.get_logger().warning, self._cannot_log, waiting=_LINES)
        self.at_end(lambda: self._lines.settle(_LAST_WORDS))
        self._driver = driver = self.hold(rm65_driver(self._settings, self._warn))
        self._telemetry = Telemetry(driver, self._outputs)
        self.get_logger().info(f"control loop runs at {driver.loop.thread.priority}")
        self.offer("arm/stop", driver.stop)
        self.offer("arm/pause", driver.pause)
        self.offer("arm/retract", driver.retract)
        self.offer_beside("arm/home", driver.home)
        self.offer_beside("arm/resume", driver.resume)
        self.offer_beside("arm/zero_force", lambda: f"{driver.zero_force():.2f} N remain")
        self._intake = Intake(self, driver, self._warn)
        self._approaches = self.act(Approach, "approach", begin=self._begin_approach, conclude=self._conclude)
        self._vendor = vendor_topics(self, driver) if self._settings.vendor_topics else None
        self.hold(Ticker(self._settings.publish_rate, self._publish, self.get_logger().fatal))

    def _warn(self, line: str) -> None:
        """Have a line logged by another thread: the control loop, too, calls this, and must not wait."""
        self._lines.put(line)

    def _cannot_log(self, error: Exception) -> None:
        self.report(WARN, f"cannot log: {error}")

    def _begin_approach(self, goal: ServerGoalHandle) -> None:
        self._approaches.run(goal, lambda: outcome_of(self, lambda: self._approach(goal)))

    def _approach(self, goal: ServerGoalHandle) -> Touch:
        def tell(remaining: float, force: float) -> None:
            goal.publish_feedback(Approach.Feedback(remaining=remaining, force=force))

        return self._driver.approach(request_from_goal(goal.request), lambda: goal.is_cancel_requested, tell)

    def _conclude(self, goal: ServerGoalHandle, outcome: Touch | BathbotError) -> Approach.Result:
        if isinstance(outcome, BathbotError):
            self._warn(f"approach: {outcome}")
            goal.canceled() if goal.is_cancel_requested else goal.abort()
        else:
            goal.succeed()
        return approach_result(outcome, self.get_clock().now().to_msg())

    def _publish(self) -> None:
        if self._vendor is not None:
            self._vendor.publish()
        snapshot = self._telemetry.publish(self.get_clock().now().to_msg())
        if snapshot is not None:
            found = health(self._driver, snapshot, self._intake.refused)
            level = ERROR if not found.sound else WARN if found.doubtful else OK
            self.report(level, found.message, **diagnostic_values(self._driver, snapshot))


def main() -> None:
    """Run the node."""
    prefer_process()
    keep_clear_of_shared_memory()
    run(
        Rm65Driver,
        "--disable-external-lib-logs",  # a disk that hangs would hold the interpreter's lock
        executor=SingleThreadedExecutor,  # another knows neither coroutines nor who takes its own messages
    )


if __name__ == "__main__":
    main()
