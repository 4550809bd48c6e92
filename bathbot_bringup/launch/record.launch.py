"""A bag of the running graph: ros2 launch bathbot_bringup record.launch.py bag:=monday profile:=default."""

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
        ("profile", "default", "privacy profile: default, arm or calibration"),
        ("consent", "", "who agreed and when; profiles with pictures need it"),
        (
            "params_file",
            PathJoinSubstitution([share, "config", "overlay.yaml"]),
            "parameters laid over the file",
        ),
        ("log_level", "info", "debug, info, warn or error"),
    ]
    chosen = ("bag", "profile", "consent")
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
