"""From raw pictures to scrub segments; the other launch files include this one and add their sources.

ros2 launch bathbot_bringup pipeline.launch.py calibration:=d455.npz hand_eye:=hand_eye.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    overlay = PathJoinSubstitution([FindPackageShare("bathbot_bringup"), "config", "overlay.yaml"])
    arguments = [
        ("namespace", "", "namespace of all nodes"),
        ("params_file", overlay, "parameters laid over the nodes' own files"),
        ("use_sim_time", "false", "take the time from /clock"),
        ("autostart", "true", "nodes configure and activate by themselves"),
        ("log_level", "info", "debug, info, warn or error"),
        ("calibration", "", "depth calibration .npz; empty: depth passes uncorrected"),
        ("hand_eye", "", "hand-eye calibration .yaml"),
        ("model", "", "detector .onnx; empty: the one of bathbot_perception"),
        ("region", "Trunk_skin", "region that is selected at the start"),
    ]
    text = {name: ParameterValue(LaunchConfiguration(name), value_type=str) for name, *_ in arguments}
    stages = [
        ("bathbot_depthcorr", "depth_corrector", {"calibration": text["calibration"]}),
        ("bathbot_perception", "skin_detector", {"model": text["model"]}),
        ("bathbot_localize", "target_localizer", {"hand_eye": text["hand_eye"], "region": text["region"]}),
        ("bathbot_scrub", "scrub_planner", {}),
    ]
    switches = {
        name: ParameterValue(LaunchConfiguration(name), value_type=bool)
        for name in ("use_sim_time", "autostart")
    }
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
                {**parameters, **switches},
            ],
            arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
        )
        for package, name, parameters in stages
    ]
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, default, about in arguments
            ),
            GroupAction([PushRosNamespace(LaunchConfiguration("namespace")), *nodes]),
        ]
    )
