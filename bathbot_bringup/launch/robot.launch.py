"""The whole graph on a real D455 and a real RM65-6F.

ros2 launch bathbot_bringup robot.launch.py arm_host:=192.168.1.18 calibration:=d455.npz hand_eye:=eye.yaml
"""

from bathbot_depthcorr.node.dds import transport
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    SetEnvironmentVariable,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode, Node, PushRosNamespace
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
        ("arm_host", "192.168.1.18", "address of the RM65 controller"),
        ("serial", "", "serial number of the D455; empty: the first that is found"),
        ("profile", "848x480x30", "width, height and rate of depth and colour"),
        ("calibration", "", "depth calibration .npz of this camera"),
        ("hand_eye", "", "hand-eye calibration .yaml"),
        ("model", "", "detector .onnx; empty: the one of bathbot_perception"),
    ]
    camera = Node(  # topics /camera/camera/...; depth must stay raw, not aligned to colour
        package="realsense2_camera",
        executable="realsense2_camera_node",
        name="camera",
        namespace="camera",
        output="screen",
        parameters=[
            {
                "serial_no": ParameterValue(LaunchConfiguration("serial"), value_type=str),
                "depth_module.depth_profile": ParameterValue(LaunchConfiguration("profile"), value_type=str),
                "rgb_camera.color_profile": ParameterValue(LaunchConfiguration("profile"), value_type=str),
                "enable_sync": True,
                "align_depth.enable": False,
                "pointcloud.enable": False,
                "diagnostics_period": 1.0,
            }
        ],
    )
    driver = LifecycleNode(
        package="bathbot_scrub",
        executable="rm65_driver",
        name="rm65_driver",
        namespace="",
        output="screen",
        parameters=[
            PathJoinSubstitution([FindPackageShare("bathbot_scrub"), "config", "rm65_driver.yaml"]),
            LaunchConfiguration("params_file"),
            {
                "host": ParameterValue(LaunchConfiguration("arm_host"), value_type=str),
                "autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool),
            },
        ],
        arguments=["--ros-args", "--log-level", LaunchConfiguration("log_level")],
    )
    passed = ("namespace", "params_file", "autostart", "log_level", "calibration", "hand_eye", "model")
    pipeline = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(PathJoinSubstitution([share, "launch", "pipeline.launch.py"])),
        launch_arguments={name: LaunchConfiguration(name) for name in passed}.items(),
    )
    # Our own nodes see to it themselves; the camera's driver would show its pictures to the network.
    reach = [SetEnvironmentVariable(name, value) for name, value in transport.variables().items()]
    return LaunchDescription(
        [
            *reach,
            *(
                DeclareLaunchArgument(name, default_value=default, description=about)
                for name, default, about in arguments
            ),
            GroupAction([PushRosNamespace(LaunchConfiguration("namespace")), camera, driver]),
            pipeline,
        ]
    )
