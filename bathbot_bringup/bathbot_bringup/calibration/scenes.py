"""Recording the simulated calibration scenes: sim_camera, the recorder and, for the marker, the arm."""

import datetime
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bathbot_scrub.installed_arm import installed_arm
from bathbot_scrub.rm65.controller.client import ArmClient
from bathbot_scrub.rm65.controller.protocol import joints_to_wire
from numpy.typing import NDArray

from bathbot_bringup.bag.reading import summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import refuse_existing, remove_bag
from bathbot_bringup.bag.recording.privacy import Consent
from bathbot_bringup.calibration.marker_poses import marker_poses
from bathbot_bringup.errors import StepError
from bathbot_bringup.files import log_folder
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.isolation import Ports, free_ports
from bathbot_bringup.graph.node_table import Parameters
from bathbot_bringup.graph.running import running
from bathbot_bringup.sim.camera.d455_unit import find_preset, make_unit
from bathbot_bringup.sim.scene import true_camera_pose

BOARD_HOLD, BOARD_RATE = 3.0, 2.5  # [s] a place lasts, [Hz] of the camera: still 3 pictures when it is slow
MARKER_HOLD, MARKER_RATE = 2.0, 4.0  # [s], [Hz]
_MOVE = 15.0  # [s] one motion may take
_SPEED = 30  # [%] of the joints' speed


@dataclass(frozen=True, slots=True)
class BoardScene:
    """A chessboard on a wall; see `bathbot simulate board`."""

    out: Path
    poses: int
    seed: int
    preset: str
    size: tuple[int, int] = (848, 480)  # [px]

    def __post_init__(self) -> None:
        """Refuse what cannot be recorded."""
        refuse_existing(self.out)
        make_unit(1, find_preset(self.preset), *self.size)


@dataclass(frozen=True, slots=True)
class MarkerScene:
    """A marker on the arm; see `bathbot simulate marker`."""

    out: Path
    poses: int
    seed: int

    def __post_init__(self) -> None:
        """Refuse what cannot be recorded."""
        refuse_existing(self.out)


def simulate_board(scene: BoardScene) -> int:
    """Record a camera that stands still before a chessboard, place after place.

    Returns:
        Number of messages in the bag.

    Raises:
        BringupError: When a node fails.
    """
    camera = {
        "scene": "chessboard", "seed": scene.seed, "preset": scene.preset, "rate": BOARD_RATE,
        "poses": scene.poses, "hold": BOARD_HOLD, "width": scene.size[0], "height": scene.size[1],
    }  # fmt: skip
    with _recording(scene.out, {"sim_camera": camera}) as client:
        client.wait(scene.poses * BOARD_HOLD + 1.0)
    return _count(scene.out)


def simulate_marker(scene: MarkerScene, tell: Callable[[str], None]) -> int:
    """Record an arm that shows its marker, pose after pose.

    Returns:
        Number of messages in the bag.

    Raises:
        BringupError: When a node fails or the arm does not move.
    """
    ports = free_ports()
    nodes = {
        "sim_rm65": {"person": False, "port": ports.tcp, "udp_port": ports.udp},
        "rm65_driver": {"host": "127.0.0.1", "port": ports.tcp, "udp_port": ports.udp},
        "sim_camera": {"scene": "aruco", "seed": scene.seed, "rate": MARKER_RATE},
    }
    poses = marker_poses(true_camera_pose(), installed_arm().home, scene.poses, scene.seed)
    with _recording(scene.out, nodes) as client:
        mover = _Mover(client, ports)
        try:
            for number, joints in enumerate(poses, start=1):
                mover.move(joints)
                client.wait(MARKER_HOLD)
                tell(f"pose {number} of {len(poses)}")
        finally:
            mover.close()
    return _count(scene.out)


@contextmanager
def _recording(out: Path, nodes: Mapping[str, Parameters]) -> Iterator[GraphClient]:
    """Run nodes and the recorder; yields a client of their graph once all are active."""
    consent = Consent("nobody", datetime.date.today().isoformat(), "simulated scene, no person")
    recorder = {"bag": out.absolute(), "profile": "full", **consent._asdict()}
    try:
        with (
            log_folder("simulate") as logs,
            running({"recorder": recorder, **nodes}, logs, "bathbot_simulate") as graph,
        ):
            yield graph.client
    except BaseException:
        remove_bag(out)  # the recorder has closed it in order, but it is not what was asked for
        raise


class _Mover:
    """A second client of the controller, beside the driver, that moves the joints."""

    def __init__(self, client: GraphClient, ports: Ports) -> None:
        self._client, self._settled = client, threading.Event()
        self._arm = ArmClient("127.0.0.1", ports.tcp, on_event=self._hear)
        self._arm.start()
        if not client.spin_until(lambda: self._arm.connection.connected, _MOVE):
            raise StepError(
                "marker", f"no connection to the simulated controller: {self._arm.connection.reason}"
            )

    def _hear(self, frame: dict[str, object]) -> None:
        if frame.get("state") == "current_trajectory_state":
            self._settled.set()

    def move(self, joints: NDArray[np.float64]) -> None:
        """Move the joints [rad] and wait until they are there."""
        self._settled.clear()
        frame = {
            "command": "movej",
            "v": _SPEED,
            "joint": joints_to_wire(joints),
            "trajectory_connect": 0,
            "r": 0,
        }
        self._arm.demand(frame, "receive_state")
        if not self._client.spin_until(self._settled.is_set, _MOVE):
            raise StepError(
                "marker", f"the arm did not reach {np.degrees(joints).round(1)} deg within {_MOVE:.0f} s"
            )

    def close(self) -> None:
        self._arm.close()


def _count(bag: Path) -> int:
    return sum(topic.messages for topic in summarise_bag(bag))
