"""The launch file of one node: its parameter file, some parameters as arguments, autostart, log level."""

from typing import NamedTuple

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


class Argument(NamedTuple):
    """A parameter of the node that is also an argument of the launch file."""

    name: str
    default: str
    about: str
    kind: type = str  # of the parameter


_AUTOSTART = Argument("autostart", "true", "configure and activate by itself", bool)


def one_node(package: str, executable: str, *arguments: Argument) -> LaunchDescription:
    """Start a node from `config/<executable>.yaml` of its package, under the executable's name."""
    config = PathJoinSubstitution([FindPackageShare(package), "config", f"{executable}.yaml"])
    own = (*arguments, _AUTOSTART)
    return LaunchDescription([
        DeclareLaunchArgument("params_file", default_value=config, description="parameters of the node"),
        *(DeclareLaunchArgument(one.name, default_value=one.default, description=one.about) for one in own),
        DeclareLaunchArgument("log_level", default_value="info", description="debug, info, warn or error"),
        LifecycleNode(
            package=package, executable=executable, name=executable, namespace="", output="screen",
            parameters=[
                LaunchConfiguration("params_file"),
                {one.name: ParameterValue(LaunchConfiguration(one.name), value_type=one.kind) for one in own},
            ],
            arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
        ),
    ])  # fmt: skip
