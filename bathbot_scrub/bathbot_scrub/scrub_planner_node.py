"""Plans scrub paths: `contact_targets`, `surface`, `arm_state` -> `scrub_segments`, action `scrub`.

Targets and surfaces count only as seen while the arm was free; what is seen later tells how the
skin moves. The action's status stays ACCEPTED until it ends: a waiting coroutine would keep the
executor busy.
"""

from dataclasses import replace
from functools import partial

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from bathbot_depthcorr.ros.messages import stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transform_from_pose
from bathbot_localize.arm import clearance
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState, PointCloud2
from std_srvs.srv import Trigger

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState, ContactTargets, ScrubSegment
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.messages import (
    joints_from_state,
    path_from_poses,
    report_from_arm,
    result_from_outcome,
    sighting_from_cloud,
    targets_by_region,
)
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.path.reach import Reach
from bathbot_scrub.rm65.arm.kinematics import Kinematics
from bathbot_scrub.rm65.force.force_limits import load_force_limits
from bathbot_scrub.scrub_inputs import ScrubInputs
from bathbot_scrub.scrub_job import Code, Outcome, ScrubJob, refusal
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.messages import message_from_segment
from bathbot_scrub.segment.segment import Segment


class ScrubPlanner(StageNode):
    """Holds at most one job; its thread plans, publishes and ends the goal."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("scrub_planner", ScrubPlannerSettings)

    def setup(self, settings: ScrubPlannerSettings) -> None:
        """Make the publishers."""
        self._settings = settings
        clearance.warm_up()
        self._kinematics = Kinematics(settings.arm_variant)
        self._limits = load_force_limits(settings.force_limits)
        self._segments = self.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        self._path = self.create_publisher(Path, "planned_path", LATCHED)
        self._pause = self.create_client(Trigger, "arm/pause")

    def start(self) -> None:
        """Listen to localiser and arm, and take goals."""
        self._inputs = ScrubInputs(self._settings)
        self._job: ScrubJob | None = None
        self._outcomes: dict[bytes, Outcome] = {}  # of goals that have ended, by their id
        listen = self.create_subscription
        self._subscriptions_made = [
            listen(ContactTargets, "contact_targets", self._on_targets, 10),
            listen(PointCloud2, "surface", self._on_surface, 5),
            listen(ArmState, "arm_state", self._on_arm, 10),
            listen(PoseStamped, "tool_pose", self._on_head, 1),
            listen(PointCloud2, "body_cloud", self._on_body, 1),
            listen(JointState, "joint_states", self._on_joints, 1),
        ]
        self._server = ActionServer(
            self, Scrub, "scrub", self._conclude, handle_accepted_callback=self._on_goal,
            goal_callback=lambda _: GoalResponse.ACCEPT, cancel_callback=self._on_cancel,
        )  # fmt: skip
        self.report(OK, "waiting for a goal")

    def stop(self) -> None:
        """End the job and listen no more."""
        if self._job is not None:
            self._job.cancel()
            self._job.join()
        self._server.destroy()
        for subscription in self._subscriptions_made:
            self.destroy_subscription(subscription)

    def teardown(self) -> None:
        """Let publishers and client go."""
        self.destroy_publisher(self._segments)
        self.destroy_publisher(self._path)
        self.destroy_client(self._pause)

    def _on_targets(self, message: ContactTargets) -> None:
        self._inputs.before.see_targets(targets_by_region(message), stamp_seconds(message.header.stamp))

    def _on_surface(self, message: PointCloud2) -> None:
        sighting = sighting_from_cloud(message)
        self._inputs.before.see_surface(sighting)
        if self._job is not None:
            self._job.see_surface(sighting)

    def _on_body(self, message: PointCloud2) -> None:
        self._inputs.see_body(sighting_from_cloud(message))

    def _on_head(self, message: PoseStamped) -> None:
        self._inputs.see_head(partial(transform_from_pose, message.pose))

    def _on_joints(self, message: JointState) -> None:
        self._inputs.see_joints(partial(joints_from_state, message))

    def _on_arm(self, message: ArmState) -> None:
        report = report_from_arm(message)
        self._inputs.before.see_arm(report)
        if self._job is not None:
            self._job.see_arm(report)

    def _on_goal(self, goal: ServerGoalHandle) -> None:
        """Start a job, or end the goal at once with the reason."""
        request = goal.request
        try:
            if self._job is not None:
                raise NotReadyError("another path is being scrubbed; wait for its end or cancel it")
            task = self._inputs.task(request.region, request.max_length, self._now())
        except BathbotError as error:
            self._end(goal, refusal(error))
            return
        self._job = ScrubJob(
            task.path_id,
            lambda: self._plan(task),
            lambda segment, seconds: self._send(goal, segment, seconds),
            lambda outcome: self._finish(goal, outcome),
            self._now,
            self._settings,
        )
        self.get_logger().info(f"scrubbing {task.region}, path {task.path_id}")
        self.report(OK, f"scrubbing {task.region}")
        self._job.see_arm(self._inputs.before.arm)
        self._job.start()

    def _plan(self, task: Task) -> PathPlanner:
        """Choose the path, pressed in as is comfortable there, and show it; in the job's thread."""
        pressed = self._limits.comfortable(task.region, self._settings.compression)
        body = self._inputs.body(self._now())
        planner = PathPlanner(
            task,
            replace(self._settings, compression=pressed),
            Reach(self._kinematics, task.joints, body),
        )
        self._path.publish(path_from_poses(planner.poses, task.stamp))
        self.get_logger().info(planner.summary)
        self._planner = planner
        return planner

    def _send(self, goal: ServerGoalHandle, segment: Segment, seconds: float) -> None:
        self._segments.publish(message_from_segment(segment))
        under_head = self._inputs.before.arm.segment_on(segment.path_id)
        goal.publish_feedback(Scrub.Feedback(
            segment_index=under_head, fraction=self._planner.fraction, planning_time=seconds))  # fmt: skip
        self.report(OK, f"scrubbing {goal.request.region}", segment=segment.index, planning_ms=1e3 * seconds)

    def _finish(self, goal: ServerGoalHandle, outcome: Outcome) -> None:
        """End the job; in its thread. Where it broke off in contact the arm must not use up its queue."""
        if outcome.broke_off:
            if self._pause.service_is_ready():
                self._pause.call_async(Trigger.Request())
            else:
                self.get_logger().error("service arm/pause is not there: the arm follows what it was sent")
        self._job = None
        self._end(goal, outcome)

    def _end(self, goal: ServerGoalHandle, outcome: Outcome) -> None:
        self._tell(goal.request.region, outcome)
        self._outcomes[bytes(goal.goal_id.uuid)] = outcome
        goal.execute()

    def _conclude(self, goal: ServerGoalHandle) -> Scrub.Result:
        """Give a goal that has ended its final state; runs in the executor and does not wait."""
        outcome = self._outcomes.pop(bytes(goal.goal_id.uuid))
        if outcome.code == Code.NONE:
            goal.succeed()
        elif outcome.code == Code.CANCELED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result_from_outcome(outcome)

    def _tell(self, region: str, outcome: Outcome) -> None:
        text, log = outcome.told(region), self.get_logger()
        if outcome.code is Code.NONE:
            level = OK
            log.info(text)
        else:
            level = WARN if outcome.harmless else ERROR
            log.error(text)
        self.report(level, text)

    def _on_cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        if self._job is not None:
            self._job.cancel()
        return CancelResponse.ACCEPT

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9


def main() -> None:
    """Run the node."""
    run(ScrubPlanner)


if __name__ == "__main__":
    main()
