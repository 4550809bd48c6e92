"""The skin detector by itself: ros2 launch bathbot_perception skin_detector.launch.py."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("bathbot_perception"), "config", "skin_detector.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("params_file", default_value=config, description="parameters of the node"),
            DeclareLaunchArgument(
                "autostart", default_value="true", description="configure and activate by itself"
            ),
            DeclareLaunchArgument(
                "log_level", default_value="info", description="debug, info, warn or error"
            ),
            LifecycleNode(
                package="bathbot_perception",
                executable="skin_detector",
                name="skin_detector",
                namespace="",
                output="screen",
                parameters=[
                    LaunchConfiguration("params_file"),
                    {"autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool)},
                ],
                arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
            ),
        ]
    )
