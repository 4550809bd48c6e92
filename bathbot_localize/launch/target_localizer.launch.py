"""The target localiser by itself: ros2 launch bathbot_localize target_localizer.launch.py."""

from bathbot_depthcorr.one_node_launch import one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node("bathbot_localize", "target_localizer")
