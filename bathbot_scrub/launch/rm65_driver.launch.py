"""The arm driver by itself: ros2 launch bathbot_scrub rm65_driver.launch.py host:=192.168.1.18."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("bathbot_scrub"), "config", "rm65_driver.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("params_file", default_value=config, description="parameters of the node"),
            DeclareLaunchArgument("host", default_value="127.0.0.1", description="address of the controller"),
            DeclareLaunchArgument("port", default_value="8080", description="its TCP port"),
            DeclareLaunchArgument(
                "autostart", default_value="true", description="configure and activate by itself"
            ),
            DeclareLaunchArgument(
                "log_level", default_value="info", description="debug, info, warn or error"
            ),
            LifecycleNode(
                package="bathbot_scrub",
                executable="rm65_driver",
                name="rm65_driver",
                namespace="",
                output="screen",
                parameters=[
                    LaunchConfiguration("params_file"),
                    {
                        "host": ParameterValue(LaunchConfiguration("host"), value_type=str),
                        "port": ParameterValue(LaunchConfiguration("port"), value_type=int),
                        "autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool),
                    },
                ],
                arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
            ),
        ]
    )
