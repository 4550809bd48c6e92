"""The emulated RM65 controller by itself: ros2 launch bathbot_bringup sim_rm65.launch.py seed:=3."""

from bathbot_depthcorr.one_node_launch import Argument, one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node(
        "bathbot_bringup",
        "sim_rm65",
        Argument("port", "8080", "TCP port to listen on", int),
        Argument("seed", "0", "of the person", int),
    )
