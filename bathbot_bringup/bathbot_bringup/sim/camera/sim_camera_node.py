"""The simulated D455 on the topics of realsense2_camera: colour, depth, infos, extrinsics, frames."""

import threading
import time

import numpy as np
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, StageNode
from bathbot_depthcorr.ros.messages import (
    extrinsics_from_transform,
    image_from_colour,
    image_mm_from_depth,
    info_from_pinhole,
    stamp_from_seconds,
)
from bathbot_localize.messages import message_from_transform
from bathbot_scrub.installed_arm import installed_arm
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image, JointState
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from bathbot_bringup.sim.camera.d455_camera import D455Camera, camera_frames
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings

COLOUR_FRAME, DEPTH_FRAME = "camera_color_optical_frame", "camera_depth_optical_frame"
ARM_SILENCE = 2.0  # [s] after which the last joint angles are no longer drawn


class SimCamera(StageNode):
    """Takes pictures in a thread of its own; the arm is drawn where joint_states say it is."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("sim_camera", SimCameraSettings)

    def setup(self, settings: SimCameraSettings) -> None:
        """Set the scene and advertise the topics."""
        self._settings, self._camera = settings, D455Camera(settings)
        self._colour = self.create_publisher(Image, "camera/camera/color/image_raw", 5)
        self._colour_info = self.create_publisher(CameraInfo, "camera/camera/color/camera_info", 5)
        self._depth = self.create_publisher(Image, "camera/camera/depth/image_rect_raw", 5)
        self._depth_info = self.create_publisher(CameraInfo, "camera/camera/depth/camera_info", 5)
        self._extrinsics = self.create_publisher(
            Extrinsics, "camera/camera/extrinsics/depth_to_color", LATCHED
        )
        self._static = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self._temperatures = self.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def start(self) -> None:
        """Publish what stays, then take pictures."""
        unit, now = self._camera.unit, self._now()
        self._epoch = self._settings.epoch or now
        self._arm: tuple[float, np.ndarray] | None = None
        self._taken, self._trouble = 0, ""
        self._extrinsics.publish(extrinsics_from_transform(unit.published_T_colour_depth))
        self._static.publish(_static_message(camera_frames(unit), now))
        self._joints = self.create_subscription(JointState, "joint_states", self._hear_joints, 10)
        self._second = self.create_timer(1.0, self._diagnose)
        self._running = threading.Event()
        self._running.set()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Take no more pictures."""
        self._running.clear()
        self._thread.join(5.0)
        self.destroy_timer(self._second)
        self.destroy_subscription(self._joints)

    def teardown(self) -> None:
        """Let the scene go."""
        for publisher in (
            self._colour,
            self._colour_info,
            self._depth,
            self._depth_info,
            self._extrinsics,
            self._static,
            self._temperatures,
        ):
            self.destroy_publisher(publisher)
        del self._camera

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9

    def _hear_joints(self, message: JointState) -> None:
        angles = dict(zip(message.name, message.position, strict=False))
        names = installed_arm().joint_names
        if all(name in angles for name in names):
            self._arm = time.monotonic(), np.array([angles[name] for name in names])

    def _run(self) -> None:
        """The thread: one pair of pictures after another."""
        due = time.monotonic()
        while self._running.is_set():
            try:
                self._publish()
                self._taken += 1
            except Exception as error:  # the thread must not die unseen; the diagnostic says why
                self._trouble = f"{type(error).__name__}: {error}"
                self.get_logger().fatal(self._trouble, throttle_duration_sec=10.0)
            due = max(due + 1.0 / self._settings.rate, time.monotonic())
            time.sleep(due - time.monotonic() if due > time.monotonic() else 0.0)

    def _publish(self) -> None:
        """Take one pair of pictures and send it; the stamp is the moment it shows."""
        now, arm = self._now(), self._arm
        joints = arm[1] if arm is not None and time.monotonic() - arm[0] < ARM_SILENCE else None
        shot, unit = self._camera.shoot(now - self._epoch, joints), self._camera.unit
        stamp = stamp_from_seconds(now)
        colour, depth = Header(stamp=stamp, frame_id=COLOUR_FRAME), Header(stamp=stamp, frame_id=DEPTH_FRAME)
        self._depth_info.publish(info_from_pinhole(unit.published_depth, depth))
        self._depth.publish(image_mm_from_depth(shot.depth, depth))
        self._colour_info.publish(info_from_pinhole(unit.published_colour, colour))
        self._colour.publish(image_from_colour(shot.colour, colour))

    def _diagnose(self) -> None:
        """Once per second: how it goes, and the temperature as the real driver tells it."""
        pictures, self._taken = self._taken, 0
        if self._trouble:
            self.report(ERROR, self._trouble)
        else:
            self.report(OK, "taking pictures", pictures_per_second=pictures, scene=self._settings.scene)
        status = DiagnosticStatus(
            level=OK,
            name=f"{self.get_name()}: Temperatures",
            hardware_id=self._camera.unit.serial,
            message="OK",
            values=[KeyValue(key="Asic Temperature", value=f"{self._settings.celsius:.1f}")],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self._temperatures.publish(message)


def _static_message(frames: list[tuple[str, str, np.ndarray]], now: float) -> TFMessage:
    header = {parent: Header(stamp=stamp_from_seconds(now), frame_id=parent) for parent, _, _ in frames}
    return TFMessage(
        transforms=[
            TransformStamped(
                header=header[parent], child_frame_id=child, transform=message_from_transform(transform)
            )
            for parent, child, transform in frames
        ]
    )


def main() -> None:
    """Run the node."""
    run(SimCamera)


if __name__ == "__main__":
    main()
