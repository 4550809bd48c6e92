"""Node `rm65_driver`: the arm on the graph. Decodes, calls `ArmDriver`, encodes."""

import os
import sys
import threading
from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.stage_node import ERROR, OK, WARN, StageNode, run
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.qos import QoSProfile
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState, ScrubSegment
from bathbot_scrub.rm65.approach import Touch
from bathbot_scrub.rm65.driver import ArmDriver, Snapshot
from bathbot_scrub.rm65.driver_settings import DriverSettings
from bathbot_scrub.rm65.errors import ArmError
from bathbot_scrub.rm65.force_guard import State
from bathbot_scrub.rm65.messages import (
    arm_state_message,
    error_code,
    joint_state_message,
    pose_stamped,
    request_from_goal,
    segment_from_message,
    stamp_of,
    tree_message,
    wrench_message,
)
from bathbot_scrub.rm65.period import prefer_process

_TREE_EVERY, _STATE_EVERY, _REPORT_EVERY = 2, 5, 50  # ticks of the 100 Hz timer


class Rm65Driver(StageNode):
    """Drives an RM65 by the vendor's protocol, real or emulated."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("rm65_driver", DriverSettings)

    def setup(self, settings: DriverSettings) -> None:
        """Create the topics."""
        self._settings = settings
        self._joints = self.create_publisher(JointState, "joint_states", 10)
        self._wrench = self.create_publisher(WrenchStamped, "wrench", 10)
        self._filtered = self.create_publisher(WrenchStamped, "wrench_filtered", 10)
        self._pose = self.create_publisher(PoseStamped, "tool_pose", 10)
        self._tree = self.create_publisher(TFMessage, "/tf", 100)
        self._state = self.create_publisher(ArmState, "arm_state", 10)

    def start(self) -> None:
        """Connect, and offer what the arm can do."""
        self._driver = driver = ArmDriver(self._settings, self._warn)
        self._ticks, self._shown, self._refused = 0, (State.FREE, ""), ""
        self._parts: list[Any] = [
            self.create_service(Trigger, f"arm/{name}", self._answer(action))
            for name, action in (
                ("stop", driver.stop),
                ("pause", driver.pause),
                ("resume", driver.resume),
                ("retract", driver.retract),
                ("home", driver.home),
            )
        ]
        self._parts.append(self.create_service(Trigger, "arm/zero_force", self._zero_force))
        self._segments = self.create_subscription(
            ScrubSegment, "scrub_segments", self._follow, QoSProfile(depth=50)
        )
        self._action = ActionServer(
            self,
            Approach,
            "approach",
            self._execute,
            handle_accepted_callback=self._begin_approach,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self._timer = self.create_timer(1.0 / self._settings.publish_rate, self._publish)
        self._priority_logged = False

    def stop(self) -> None:
        """Stop the arm and let go of it."""
        self.destroy_timer(self._timer)
        self._driver.close()
        for service in self._parts:
            self.destroy_service(service)
        self.destroy_subscription(self._segments)
        self._action.destroy()

    def _warn(self, line: str) -> None:
        self.get_logger().warning(line)

    def _answer(self, action: Callable[[], None]) -> Callable[..., Trigger.Response]:
        def serve(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            try:
                action()
                response.success = True
            except ArmError as error:
                response.message = str(error)
                self._warn(str(error))
            return response

        return serve

    async def _zero_force(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        outcome = await self._in_thread(self._driver.zero_force)
        response.success = not isinstance(outcome, ArmError)
        response.message = str(outcome) if isinstance(outcome, ArmError) else f"{outcome:.2f} N remain"
        return response

    def _follow(self, message: ScrubSegment) -> None:
        try:
            self._driver.follow(segment_from_message(message))
            self._refused = ""
        except ArmError as error:
            self._refused = f"segment {message.index} of path {message.path_id} refused: {error}"
            self._warn(self._refused)

    def _begin_approach(self, goal: ServerGoalHandle) -> None:
        """Approach in a thread of its own and execute the goal with the outcome: executors must not wait."""

        def work() -> None:
            outcome = self._outcome(
                lambda: self._driver.approach(
                    request_from_goal(goal.request),
                    lambda: goal.is_cancel_requested,
                    lambda remaining, force: goal.publish_feedback(
                        Approach.Feedback(remaining=remaining, force=force)
                    ),
                )
            )
            goal.execute(lambda handle: self._conclude(handle, outcome))

        threading.Thread(target=work, name="approach", daemon=True).start()

    def _conclude(self, goal: ServerGoalHandle, outcome: Touch | ArmError) -> Approach.Result:
        if isinstance(outcome, ArmError):
            self._warn(f"approach: {outcome}")
            goal.canceled() if goal.is_cancel_requested else goal.abort()
            return Approach.Result(error_code=error_code(outcome), error_msg=str(outcome))
        goal.succeed()
        contact = pose_stamped(outcome.T_base_head, self.get_clock().now().to_msg())
        return Approach.Result(contact=contact, force=outcome.force)

    def _execute(self, goal: ServerGoalHandle) -> Approach.Result:
        """Not used: every goal is executed with its outcome, by `_begin_approach`."""
        raise NotImplementedError

    def _outcome(self, function: Callable[[], Any]) -> Any:
        """Result of a call, or its ArmError."""
        try:
            return function()
        except ArmError as error:
            return error
        except Exception as error:  # in a thread nobody would see it
            self.get_logger().fatal(f"{type(error).__name__}: {error}")
            return ArmError(f"{type(error).__name__}: {error}")

    def _in_thread(self, function: Callable[[], Any]) -> Future:
        """Run what blocks for a moment beside the executor; the future holds its outcome."""
        future = Future(executor=self.executor)
        threading.Thread(target=lambda: future.set_result(self._outcome(function)), daemon=True).start()
        return future

    def _publish(self) -> None:
        self._ticks += 1
        now = self.get_clock().now().to_msg()
        sample, wrench = self._driver.link.sample, self._driver.link.wrench
        if sample is not None and wrench is not None:
            stamp = stamp_of(sample.stamp, now)
            self._joints.publish(joint_state_message(sample.joints, stamp))
            self._wrench.publish(wrench_message(wrench.raw, stamp))
            self._filtered.publish(wrench_message(wrench.filtered, stamp))
            self._pose.publish(pose_stamped(self._driver.kinematics.head(sample.joints), stamp))
            if self._ticks % _TREE_EVERY == 0:
                self._tree.publish(tree_message(self._driver.kinematics, sample.joints, stamp))
        guard = self._driver.loop.guard
        if self._ticks % _STATE_EVERY == 0 or (guard.state, guard.reason) != self._shown:
            snapshot = self._driver.snapshot()
            self._shown = (guard.state, guard.reason)
            self._state.publish(arm_state_message(snapshot, stamp_of(sample.stamp, now) if sample else now))
            if self._ticks % _REPORT_EVERY < _STATE_EVERY:
                self._report(snapshot)

    def _report(self, snapshot: Snapshot) -> None:
        if not self._priority_logged and self._driver.loop.priority:
            self._priority_logged = True
            self.get_logger().info(f"control loop runs at {self._driver.loop.priority}")
        healthy = snapshot.connected and snapshot.state is not State.FAULT
        level = (WARN if self._refused else OK) if healthy else ERROR
        statistics, receiver = self._driver.loop.statistics, self._driver.link.receiver
        self.report(
            level,
            self._refused or snapshot.reason or snapshot.state.name,
            state=snapshot.state.name,
            connected=snapshot.connected,
            force=f"{snapshot.force:.2f}",
            samples=receiver.accepted,
            samples_refused=receiver.rejected,
            commands=statistics.sent,
            periods_missed=statistics.missed,
            period_deviation_p99_ms=f"{snapshot.period_deviation_p99 * 1e3:.3f}",
            priority=self._driver.loop.priority,
        )


def main() -> None:
    """Run the node."""
    sys.setswitchinterval(0.0005)  # the control loop shares the interpreter with the executor
    prefer_process()
    # a publisher that waits for a slow reader would hold the interpreter, and with it the clocked thread
    os.environ.setdefault("RMW_FASTRTPS_PUBLICATION_MODE", "ASYNCHRONOUS")
    run(Rm65Driver)


if __name__ == "__main__":
    main()
