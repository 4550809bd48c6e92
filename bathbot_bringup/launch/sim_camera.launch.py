"""The simulated D455 by itself: ros2 launch bathbot_bringup sim_camera.launch.py seed:=3."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    config = PathJoinSubstitution([FindPackageShare("bathbot_bringup"), "config", "sim_camera.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("params_file", default_value=config, description="parameters of the node"),
            DeclareLaunchArgument(
                "scene", default_value="bathroom", description="bathroom, chessboard or aruco"
            ),
            DeclareLaunchArgument("seed", default_value="0", description="of the person"),
            DeclareLaunchArgument(
                "autostart", default_value="true", description="configure and activate by itself"
            ),
            DeclareLaunchArgument(
                "log_level", default_value="info", description="debug, info, warn or error"
            ),
            LifecycleNode(
                package="bathbot_bringup",
                executable="sim_camera",
                name="sim_camera",
                namespace="",
                output="screen",
                parameters=[
                    LaunchConfiguration("params_file"),
                    {
                        "scene": ParameterValue(LaunchConfiguration("scene"), value_type=str),
                        "seed": ParameterValue(LaunchConfiguration("seed"), value_type=int),
                        "autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool),
                    },
                ],
                arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
            ),
        ]
    )
