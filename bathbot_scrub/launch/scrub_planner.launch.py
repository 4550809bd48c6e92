"""The scrub planner by itself: ros2 launch bathbot_scrub scrub_planner.launch.py."""

from bathbot_depthcorr.one_node_launch import one_node
from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return one_node("bathbot_scrub", "scrub_planner")
