"""Which nodes the demo starts, and with which parameters."""

from collections.abc import Mapping
from pathlib import Path

from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.graph.installation import SIM_HAND_EYE, config_file
from bathbot_bringup.graph.isolation import Ports
from bathbot_bringup.graph.node_table import Parameters

SEEING = ("sim_rm65", "rm65_driver", "depth_corrector", "skin_detector", "target_localizer", "sim_camera")
"""The nodes of the demo that it takes to locate a region; the arm is needed as it is masked out."""


def demo_nodes(settings: DemoSettings, epoch: float, ports: Ports, bag: Path) -> Mapping[str, Parameters]:
    """Parameters of the demo's nodes, in the order they are started.

    Args:
        settings: Of the demo.
        epoch: ROS time at which the body's motion begins [s].
        ports: For the arm.
        bag: Where to record.
    """
    body = {"seed": settings.seed, "scenario": settings.scenario, "epoch": epoch}
    return {
        "sim_rm65": {**body, "port": ports.tcp, "udp_port": ports.udp},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp},
        "scrub_planner": {},
        "depth_corrector": {"calibration": settings.calibration.absolute()},
        "skin_detector": {"threads": 1},
        "target_localizer": {
            "region": settings.region,
            "hand_eye": config_file("bathbot_bringup", SIM_HAND_EYE),
        },
        "recorder": {"bag": bag},
        "sim_camera": {**body, "rate": settings.rate, "preset": settings.preset},
    }
