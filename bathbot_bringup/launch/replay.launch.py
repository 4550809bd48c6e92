"""The pipeline over a recorded bag, without any live source.

ros2 launch bathbot_bringup replay.launch.py bag:=monday calibration:=d455.npz hand_eye:=hand_eye.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    share = FindPackageShare("bathbot_bringup")
    arguments = [
        ("bag", None, "rosbag2 folder or .mcap file"),
        ("rate", "1.0", "speed"),
        ("namespace", "", "namespace of all nodes"),
        (
            "params_file",
            PathJoinSubstitution([share, "config", "overlay.yaml"]),
            "parameters laid over all files",
        ),
        ("autostart", "true", "nodes configure and activate by themselves"),
        ("log_level", "info", "debug, info, warn or error"),
        ("calibration", "", "depth calibration .npz of the recorded camera"),
        ("hand_eye", "", "hand-eye calibration .yaml of the recorded set-up"),
        ("model", "", "detector .onnx; empty: the one of bathbot_perception"),
    ]
    replayer = LifecycleNode(
        package="bathbot_bringup",
        executable="replayer",
        name="replayer",
        namespace="",
        output="screen",
        parameters=[
            PathJoinSubstitution([share, "config", "replayer.yaml"]),
            LaunchConfiguration("params_file"),
            {
                "bag": ParameterValue(LaunchConfiguration("bag"), value_type=str),
                "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
                "autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool),
            },
        ],
        arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
    )
    passed = ("namespace", "params_file", "autostart", "log_level", "calibration", "hand_eye", "model")
    pipeline = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([share, "launch", "pipeline.launch.py"])),
        launch_arguments={
            **{name: LaunchConfiguration(name) for name in passed},
            "use_sim_time": "true",
        }.items(),
    )
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, default, about in arguments
            ),
            pipeline,
            GroupAction([PushRosNamespace(LaunchConfiguration("namespace")), replayer]),
        ]
    )
