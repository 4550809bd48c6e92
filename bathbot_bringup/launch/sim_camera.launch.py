"""The simulated D455 by itself: ros2 launch bathbot_bringup sim_camera.launch.py seed:=3."""

from bathbot_depthcorr.one_node_launch import Argument, one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node(
        "bathbot_bringup",
        "sim_camera",
        Argument("scene", "bathroom", "bathroom, chessboard or aruco"),
        Argument("seed", "0", "of the person", int),
    )
