"""The whole graph in the simulated bathroom: ros2 launch bathbot_bringup sim.launch.py seed:=3."""

from importlib.resources import files

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
        ("namespace", "", "namespace of all nodes"),
        (
            "params_file",
            PathJoinSubstitution([share, "config", "overlay.yaml"]),
            "parameters laid over all files",
        ),
        ("autostart", "true", "nodes configure and activate by themselves"),
        ("log_level", "info", "debug, info, warn or error"),
        ("seed", "0", "of person, motion and noise"),
        ("scenario", "calm", "how the person moves"),
        ("epoch", "1.0", "ROS time at which the motion begins [s]; the same for camera and arm"),
    ]
    body = {
        "seed": ParameterValue(LaunchConfiguration("seed"), value_type=int),
        "scenario": ParameterValue(LaunchConfiguration("scenario"), value_type=str),
        "epoch": ParameterValue(LaunchConfiguration("epoch"), value_type=float),
    }
    autostart = {"autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool)}
    edge = [
        ("bathbot_bringup", "sim_camera", body),
        ("bathbot_bringup", "sim_rm65", body),
        ("bathbot_scrub", "rm65_driver", {"host": "127.0.0.1"}),
    ]
    nodes = [
        LifecycleNode(
            package=package,
            executable=name,
            name=name,
            namespace="",
            output="screen",
            parameters=[
                PathJoinSubstitution([FindPackageShare(package), "config", f"{name}.yaml"]),
                LaunchConfiguration("params_file"),
                {**parameters, **autostart},
            ],
            arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
        )
        for package, name, parameters in edge
    ]
    pipeline = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([share, "launch", "pipeline.launch.py"])),
        launch_arguments={
            **{
                name: LaunchConfiguration(name)
                for name in ("namespace", "params_file", "autostart", "log_level")
            },
            "calibration": str(files("bathbot_bringup") / "sim" / "data" / "sim_d455_calibration.npz"),
            "hand_eye": PathJoinSubstitution([share, "config", "sim_hand_eye.yaml"]),
        }.items(),
    )
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, default, about in arguments
            ),
            GroupAction([PushRosNamespace(LaunchConfiguration("namespace")), *nodes]),
            pipeline,
        ]
    )
