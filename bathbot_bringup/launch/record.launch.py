"""A bag of the running graph: ros2 launch bathbot_bringup record.launch.py bag:=monday."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    share = FindPackageShare("bathbot_bringup")
    arguments = [
        ("bag", None, "new folder, or new file ending in .mcap"),
        ("profile", "metrics_only", "privacy profile: metrics_only, depth_only or full"),
        ("who", "", "who agreed to be recorded; profiles with pictures need it"),
        ("when", "", "when they agreed, such as 2026-01-31; likewise"),
        ("why", "", "what they agreed to: the purpose, and how long it is kept; likewise"),
        (
            "params_file",
            PathJoinSubstitution([share, "config", "overlay.yaml"]),
            "parameters laid over the file",
        ),
        ("log_level", "info", "debug, info, warn or error"),
    ]
    chosen = ("bag", "profile", "who", "when", "why")
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, default, about in arguments
            ),
            LifecycleNode(
                package="bathbot_bringup",
                executable="recorder",
                name="recorder",
                namespace="",
                output="screen",
                parameters=[
                    PathJoinSubstitution([share, "config", "recorder.yaml"]),
                    LaunchConfiguration("params_file"),
                    {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name in chosen},
                ],
                arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
            ),
        ]
    )
