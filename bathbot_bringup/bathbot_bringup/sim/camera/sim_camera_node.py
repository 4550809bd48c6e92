"""The simulated D455 on the topics of realsense2_camera: colour, depth, infos, extrinsics, frames."""

from typing import Any

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, OK, StageNode
from bathbot_depthcorr.ros.messages import stamp_seconds
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.installed_arm import installed_arm
from bathbot_scrub.messages import joints_from_state
from sensor_msgs.msg import JointState

from bathbot_bringup.sim.camera.d455_camera import D455Camera
from bathbot_bringup.sim.camera.sim_camera_output_node import SimCameraOutput
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings


class SimCamera(StageNode):
    """Takes pictures in a thread of its own; the arm is drawn where joint_states say it is."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters; `options` are those of rclpy's `Node`."""
        super().__init__("sim_camera", SimCameraSettings, **options)

    def setup(self, settings: SimCameraSettings) -> None:
        """Set the scene and advertise the topics."""
        self._settings, self._camera = settings, D455Camera(settings)
        self._output = SimCameraOutput(self, self._camera.unit)
        self._joint_names = installed_arm().joint_names

    def start(self) -> None:
        """Publish what stays, then take pictures."""
        self._epoch = self._settings.epoch or self.now()
        self._taken, self._trouble = 0, ""
        self._output.publish_unit(self.now())
        self.listen(JointState, "joint_states", self._hear_joints, 10)
        self.every(1.0, self._diagnose)
        photographer = self.worker(self._shoot, self._fail)
        self.every(1.0 / self._settings.rate, lambda: photographer.put(None))

    def _hear_joints(self, message: JointState) -> None:
        try:
            self._camera.hear_arm(
                joints_from_state(message, self._joint_names), stamp_seconds(message.header.stamp)
            )
        except NotReadyError:
            return  # of another arm

    def _shoot(self, _: None) -> None:
        """Take one pair of pictures and send it; the stamp is the moment it shows."""
        moment, joints = self._camera.next_moment(self.now())
        self._output.publish(self._camera.shoot(moment - self._epoch, joints), moment)
        self._taken += 1

    def _fail(self, error: Exception) -> None:
        self._trouble = f"{type(error).__name__}: {error}"
        self.get_logger().fatal(self._trouble, throttle_duration_sec=10.0)

    def _diagnose(self) -> None:
        """Once per second: how it goes, and the temperature."""
        pictures, self._taken = self._taken, 0
        if self._trouble:
            self.report(ERROR, self._trouble)
        else:
            self.report(OK, "taking pictures", pictures_per_second=pictures, scene=self._settings.scene)
        self._output.publish_temperature(self._settings.celsius, self.now())


def main() -> None:
    """Run the node."""
    run(SimCamera)


if __name__ == "__main__":
    main()
