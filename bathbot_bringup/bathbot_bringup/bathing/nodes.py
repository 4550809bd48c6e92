"""Which nodes the demo starts, and with which parameters."""

import socket
from pathlib import Path
from typing import NamedTuple

from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.graph.installation import SIM_CALIBRATION, SIM_HAND_EYE, config_file
from bathbot_bringup.graph.node_table import NodeEntry, find_node

Parameters = dict[str, object]
SEEING = ("sim_rm65", "rm65_driver", "depth_corrector", "skin_detector", "target_localizer", "sim_camera")
"""The nodes of the demo that it takes to locate a region; the arm is needed as it is masked out."""


class Ports(NamedTuple):
    """Ports between the driver and the simulated controller, on loopback."""

    tcp: int
    udp: int


def free_ports() -> Ports:
    """Ask the system for two ports that nobody uses."""
    with socket.socket() as tcp, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        tcp.bind(("127.0.0.1", 0))
        udp.bind(("127.0.0.1", 0))
        return Ports(tcp.getsockname()[1], udp.getsockname()[1])


def demo_nodes(
    settings: DemoSettings, epoch: float, ports: Ports, bag: Path
) -> list[tuple[NodeEntry, Parameters]]:
    """List the nodes of the demo in the order they are started.

    Args:
        settings: Of the demo.
        epoch: ROS time at which the body's motion begins [s].
        ports: For the arm.
        bag: Where to record.
    """
    body: Parameters = {"seed": settings.seed, "scenario": settings.scenario, "epoch": epoch}
    parameters: dict[str, Parameters] = {
        "sim_rm65": {**body, "port": ports.tcp, "udp_port": ports.udp},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp},
        "scrub_planner": {},
        "depth_corrector": {"calibration": SIM_CALIBRATION},
        "skin_detector": {"threads": 1},
        "target_localizer": {
            "region": settings.region,
            "hand_eye": config_file("bathbot_bringup", SIM_HAND_EYE),
        },
        "recorder": {"bag": bag},
        "sim_camera": {**body, "rate": settings.rate, "preset": settings.preset},
    }
    return [(find_node(name), values) for name, values in parameters.items()]
