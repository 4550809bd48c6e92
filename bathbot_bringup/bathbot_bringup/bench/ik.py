"""How long the inverse kinematics of a path take, ours beside two libraries, in turns over the same poses.

Each gets its best fair use: ours is `solve_path`, all eight branches with limits and the choice by
continuity; EAIK the faster of its batch call and its single call, which find all branches and leave limits
and choice to the caller; Pinocchio a damped Newton iteration that starts from the pose before.
"""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from bathbot_scrub.arm.tool_path import solve_path
from bathbot_scrub.rm65.arm.kinematics import BASE_HEIGHT, FOREARM, UPPER_ARM
from bathbot_scrub.rm65.arm.rm65 import RM65
from numpy.typing import NDArray

from bathbot_bringup.errors import InputError

Array = NDArray[np.float64]
_BEGIN = np.radians([10.0, -60.0, -70.0, 5.0, 60.0, 20.0])
_SWEEP = np.radians([60.0, -10.0, -25.0, 20.0, -20.0, 40.0])  # of the joints along the path
_THREADS = 2  # of EAIK's batch call
_DAMPING, _TOLERANCE, _MOST_STEPS = 1e-8, 1e-9, 50  # of the Newton iteration
_LARGEST_ERROR = 1e-6  # [m], [rad] of any solver; a fast wrong answer is none


class IkTimes(NamedTuple):
    """Medians per pose [us], and how many times ours each of the others takes."""

    ik_us_per_pose: float
    eaik_us_per_pose: float
    pin_us_per_pose: float
    ik_vs_eaik: float
    ik_vs_pin: float


def bench_ik(poses: int = 1000, rounds: int = 7) -> IkTimes:
    """Solve one path by all three, `rounds` times in turns.

    Args:
        poses: Poses of the path.
        rounds: Of which the medians are taken.

    Raises:
        InputError: When EAIK is not installed, or a solver's answer is wrong.
    """
    if poses < 100 or rounds < 1:  # coarser steps would ask for a jump
        raise InputError(f"needs 100 poses or more and 1 round or more, got {poses} and {rounds}")
    arm = RM65("6F")
    joints = _BEGIN + np.linspace(0.0, 1.0, poses)[:, None] * _SWEEP
    heads = arm.head(joints)
    solvers: tuple[Callable[[], Array], ...] = (
        lambda: solve_path(arm, heads, _BEGIN),
        _eaik_solver(arm, heads),
        _pin_solver(arm, heads),
    )
    for name, solve in zip(("ours", "EAIK", "Pinocchio"), solvers, strict=True):  # also warms up
        error = np.abs(arm.head(solve()) - heads).max()
        if not error < _LARGEST_ERROR:
            raise InputError(f"the joints found by {name} miss the path by {error:.1e}; nothing was timed")
    times = np.array([[_seconds(solve) for solve in solvers] for _ in range(rounds)])
    ours, eaik, pin = np.median(times, axis=0) / poses * 1e6
    return IkTimes(float(ours), float(eaik), float(pin), float(eaik / ours), float(pin / ours))


def _seconds(solve: Callable[[], object]) -> float:
    begin = time.perf_counter()
    solve()
    return time.perf_counter() - begin


def _eaik_solver(arm: RM65, heads: Array) -> Callable[[], Array]:
    """EAIK's faster way to solve for all branches; gives the first branch of each pose."""
    try:
        from eaik.IK_HP import HPRobot
    except ImportError:
        raise InputError("this comparison needs EAIK: pip install eaik (or bathbot's extra 'test')") from None
    z, y = np.eye(3)[2], np.eye(3)[1]
    robot = HPRobot(
        np.array([z, -y, -y, z, -y, z]),
        np.array([BASE_HEIGHT * z, 0 * z, UPPER_ARM * z, FOREARM * z, 0 * z, arm.flange_offset * z, 0 * z]),
    )
    at_zero = np.eye(4)  # EAIK's tool is upright at zero, our flange is turned
    at_zero[:3, :3] = arm.flange(np.zeros(6))[:3, :3].T
    flanges = heads @ arm.tool.T_head_flange @ at_zero
    singly = list(flanges)

    def batch() -> Array:
        return np.array([found.Q[0] for found in robot.IK_batched(singly, _THREADS)])

    def single() -> Array:
        return np.array([robot.IK(pose).Q[0] for pose in singly])

    return min((batch, single), key=lambda solve: min(_seconds(solve) for _ in range(3)))


def _pin_solver(arm: RM65, heads: Array) -> Callable[[], Array]:
    """Pinocchio's usual damped Newton iteration, from pose to pose."""
    import pinocchio as pin

    model = pin.buildModelFromXML(arm.description())
    data, last = model.createData(), model.njoints - 1
    at_joint = arm.tool.T_flange_head.copy()
    goals = [pin.SE3(head) * pin.SE3(at_joint).inverse() for head in heads]
    damping = _DAMPING * np.eye(6)

    def solve() -> Array:
        q, found = _BEGIN.copy(), np.empty((len(goals), 6))
        for index, goal in enumerate(goals):
            for _ in range(_MOST_STEPS):
                pin.forwardKinematics(model, data, q)
                apart = data.oMi[last].actInv(goal)
                error = pin.log6(apart).vector
                if np.abs(error).max() < _TOLERANCE:
                    break
                jacobian = pin.computeJointJacobian(model, data, q, last)
                q = q + jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping, error)
            found[index] = q
        return found

    return solve
