"""Starts the depth corrector alone; `calibration:=FILE` names the camera's calibration."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("bathbot_depthcorr"), "config", "depth_corrector.yaml"])
    return LaunchDescription([
        DeclareLaunchArgument("calibration", default_value="", description="the camera's .npz calibration"),
        LifecycleNode(
            package="bathbot_depthcorr", executable="depth_corrector", name="depth_corrector", namespace="",
            parameters=[config, {"calibration": LaunchConfiguration("calibration")}], output="screen",
        ),
    ])  # fmt: skip
