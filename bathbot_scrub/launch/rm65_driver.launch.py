"""The arm driver by itself: ros2 launch bathbot_scrub rm65_driver.launch.py host:=192.168.1.18."""

from bathbot_depthcorr.one_node_launch import Argument, one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node(
        "bathbot_scrub",
        "rm65_driver",
        Argument("host", "127.0.0.1", "address of the controller"),
        Argument("port", "8080", "its TCP port", int),
    )
