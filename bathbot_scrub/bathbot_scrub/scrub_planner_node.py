"""Plans scrub paths: `contact_targets`, `surface`, `arm_state` -> `scrub_segments`, action `scrub`.

Targets and surfaces count only as seen while the arm was free; what is seen later tells how the
skin moves.
"""

from functools import partial

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from bathbot_depthcorr.ros.image_decoding import stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transform_from_pose
from bathbot_localize.arm import clearance
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.action.server import ServerGoalHandle
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState, PointCloud2
from std_srvs.srv import Trigger

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState, ContactTargets, ScrubSegment
from bathbot_scrub import messages
from bathbot_scrub.arm.force_limits import load_force_limits
from bathbot_scrub.installed_arm import installed_arm
from bathbot_scrub.job.scrub_job import Code, Outcome, refusal
from bathbot_scrub.job.scrub_session import Listeners, ScrubSession
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.messages import message_from_segment
from bathbot_scrub.segment.segment import Segment


class ScrubPlanner(StageNode):
    """Decodes what is seen for a `ScrubSession` and tells what comes of a goal."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("scrub_planner", ScrubPlannerSettings)

    def setup(self, settings: ScrubPlannerSettings) -> None:
        """Make the publishers."""
        self._settings = settings
        clearance.warm_up()
        self._arm = installed_arm(settings.arm_variant)
        self._limits = load_force_limits(settings.force_limits)
        self._segments = self.publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        self._path = self.publisher(Path, "planned_path", LATCHED)
        self._pause = self.client(Trigger, "arm/pause")

    def start(self) -> None:
        """Listen to localiser and arm, and take goals."""
        session = self.hold(ScrubSession(self._arm, self._limits, self._settings, self.now))
        self._session, inputs = session, session.inputs
        self.listen(ContactTargets, "contact_targets", self._on_targets, 10)
        self.listen(PointCloud2, "surface", lambda m: session.see_surface(messages.sighting_from_cloud(m)), 5)
        self.listen(ArmState, "arm_state", lambda m: session.see_arm(messages.report_from_arm(m)), 10)
        self.listen(
            PoseStamped, "tool_pose", lambda m: inputs.see_head(partial(transform_from_pose, m.pose)), 1
        )
        self.listen(PointCloud2, "body_cloud", lambda m: inputs.see_body(messages.sighting_from_cloud(m)), 1)
        self.listen(JointState, "joint_states", self._on_joints, 1)
        self._goals = self.act(
            Scrub, "scrub", begin=self._on_goal, conclude=self._conclude, cancel=session.cancel
        )
        self.report(OK, "waiting for a goal")

    def _on_targets(self, message: ContactTargets) -> None:
        stamp = stamp_seconds(message.header.stamp)
        self._session.inputs.before.see_targets(messages.targets_by_region(message), stamp)

    def _on_joints(self, message: JointState) -> None:
        self._session.inputs.see_joints(partial(messages.joints_from_state, message, self._arm.joint_names))

    def _on_goal(self, goal: ServerGoalHandle) -> None:
        end, send = partial(self._end, goal), partial(self._send, goal)
        listeners = Listeners(self._tell_begin, self._show, send, self._pause_arm, end)
        try:
            self._session.begin(goal.request.region, goal.request.max_length, listeners)
        except BathbotError as error:
            end(refusal(error))

    def _tell_begin(self, task: Task) -> None:
        self.get_logger().info(f"scrubbing {task.region}, path {task.path_id}")
        self.report(OK, f"scrubbing {task.region}")

    def _show(self, task: Task, planner: PathPlanner) -> None:
        self._path.publish(messages.path_from_poses(planner.poses, task.stamp))
        self.get_logger().info(planner.summary)

    def _send(self, goal: ServerGoalHandle, segment: Segment, seconds: float, fraction: float) -> None:
        self._segments.publish(message_from_segment(segment))
        under_head = self._session.inputs.before.arm.segment_on(segment.path_id)
        feedback = Scrub.Feedback(segment_index=under_head, fraction=fraction, planning_time=seconds)
        goal.publish_feedback(feedback)
        self.report(OK, f"scrubbing {segment.region}", segment=segment.index, planning_ms=1e3 * seconds)

    def _pause_arm(self) -> None:
        if self._pause.service_is_ready():
            self._pause.call_async(Trigger.Request())
        else:
            self.get_logger().error("service arm/pause is not there: the arm follows what it was sent")

    def _end(self, goal: ServerGoalHandle, outcome: Outcome) -> None:
        text, log = outcome.told(goal.request.region), self.get_logger()
        if outcome.code is Code.NONE:
            log.info(text)
            self.report(OK, text)
        else:
            log.error(text)
            self.report(WARN if outcome.harmless else ERROR, text)
        self._goals.end(goal, outcome)

    def _conclude(self, goal: ServerGoalHandle, outcome: Outcome) -> Scrub.Result:
        canceled = outcome.code is Code.CANCELED and goal.is_cancel_requested
        conclude = goal.succeed if outcome.code is Code.NONE else goal.canceled if canceled else goal.abort
        conclude()
        return messages.result_from_outcome(outcome)


def main() -> None:
    """Run the node."""
    run(ScrubPlanner)


if __name__ == "__main__":
    main()
