"""The depth corrector by itself: ros2 launch bathbot_depthcorr depth_corrector.launch.py calibration:=F."""

from bathbot_depthcorr.one_node_launch import Argument, one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node(
        "bathbot_depthcorr",
        "depth_corrector",
        Argument("calibration", "", "the camera's .npz calibration"),
    )
