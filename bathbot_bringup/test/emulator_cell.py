"""A cell for tests: emulated controller, a wall with exact answers, and the arm driver, without ROS.

The machine may be busy, hence the long deadlines.
"""

import gc
import time
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import AXIS, TARGET, ready_deg
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.arm.emulator.surface import PlaneSurface
from bathbot_scrub.rm65.driver import rm65_driver
from bathbot_scrub.rm65.motion.approach import Request
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.segment.segment import Segment

REGION = "Trunk_skin"
READY_DEG = ready_deg(0.10)  # at home a little behind the stand-off, to save time


@dataclass
class Wall:
    """A wall through the target; a positive shift [m] brings it nearer to the arm."""

    shift: float = 0.0
    plane: PlaneSurface = field(init=False)

    def __post_init__(self):
        self.plane = PlaneSurface(tuple(-AXIS), float(-AXIS @ TARGET[:3, 3]), REGION, lambda t: self.shift)

    def distance(self, origins, directions, t):
        return self.plane.distance(origins, directions, t)


def until(condition, timeout=20.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "not in time"
        time.sleep(0.01)


class Cell:
    """Emulator, wall, driver, and what was logged."""

    def __init__(self, **settings):
        self.wall, self.log = Wall(), []
        values = {
            "udp_port": 0,
            "stale_after": 2.0,
            "wait_at_most": 10.0,
            "deaf_after": 1.0,
            "joint_speed": 2.0,
            "joint_acceleration": 6.0,
            "approach_speed": 0.05,
            "standoff": 0.03,
            "home_deg": READY_DEG,
        } | settings
        self.emulator = Emulator(EmulatorSettings(port=0, joints_deg=values["home_deg"]), self.wall)
        values["port"] = self.emulator.port
        self.driver = rm65_driver(DriverSettings(**values), self.log.append)

    def state(self):
        return self.driver.snapshot().state

    def approach(self):
        return self.driver.approach(Request(TARGET, REGION))

    def gap(self):
        """Distance of the true head from the wall [m]; negative when pressed."""
        return float(AXIS @ (TARGET[:3, 3] - self.emulator.truth().T_base_head[:3, 3])) - self.wall.shift

    def close(self):
        self.driver.close()
        self.emulator.close()


@contextmanager
def running(**settings):
    gc.collect()
    gc.freeze()  # as nodes do: a search through all that a test session holds would stall arm and driver
    cell = Cell(**settings)
    try:
        until(lambda: cell.driver.snapshot().connected)
        yield cell
    finally:
        cell.close()
        gc.unfreeze()


def segments(count=3, speed=0.10, depth=0.005):
    """Straight paths of 20 mm pieces along y of the head, from just beside the target."""
    result = []
    for index in range(count):
        poses = np.tile(TARGET, (11, 1, 1))
        along = 0.02 * index - 0.01 + np.linspace(0.0, 0.02, 11)
        poses[:, :3, 3] += along[:, None] * TARGET[:3, 1] + depth * AXIS
        result.append(Segment(7, index, index == count - 1, REGION, poses, speed))
    return result
