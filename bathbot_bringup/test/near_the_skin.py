"""An arm a little before the skin, in virtual time, for tests of what it does there."""

import numpy as np
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import AXIS, TARGET, VirtualCell, ready_deg
from bathbot_bringup.sim.arm.controller.controller import STEP
from emulator_cell import REGION

# at home a little behind the stand-off, to save time; the search at its fastest
NEAR = {"home_deg": ready_deg(0.06), "standoff": 0.03, "approach_speed": 0.06}
AT_ONCE = 100.0  # [m/s] at which a person leans who is there between two steps of the controller


def cell_near(seed=1, **settings):
    return VirtualCell(REGION, seed, **NEAR | settings)


def at_last(cell, condition, within):
    """Let time pass until something holds, looked at every 5 ms; fail when it does not in time [s]."""
    end = cell.clock() + within
    while not condition():
        assert cell.clock() < end, f"{cell.state().name}: {cell.driver.snapshot().reason}"
        cell.wait(STEP)


def settle(cell):
    """Let a motion end."""
    at_last(cell, lambda: not cell.driver.loop.moving, 2.0)


def touch(cell, region=REGION):
    """Bring the head to rest on the skin."""
    cell.approach(region=region)
    settle(cell)
    return cell


def off_the_normal(cell):
    """Distance of the true head from the normal through the target [m]."""
    return np.linalg.norm(np.cross(cell.controller.T_base_head[:3, 3] - TARGET[:3, 3], AXIS))
