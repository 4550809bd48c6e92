"""Poses before the arm, and paths through them."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace
from scipy.spatial.transform import Rotation

ARM = RM65("6F")
HOME = ARM.home
JOINT_PACE = Pace(1.0, 2.0, 20.0)
PLANNER = MotionPlanner(ARM, HOME, JOINT_PACE, 0.5)
PERIOD = 0.01


def facing(position, yaw=0.0, pitch=0.0, roll=0.0):
    """Head pose whose z axis points along x, turned by yaw and pitch [deg]."""
    turn = Rotation.from_euler("zyx", [yaw, 90.0 + pitch, roll], degrees=True).as_matrix()
    return transform_from(turn, position)


TARGET = facing((0.57, 0.0, 0.2), yaw=-25.0, pitch=5.0)
TOUCH = nearest(ARM.solve_head(TARGET), np.radians([0, -60, -90, 0, 60, 0]), ARM.limits)


def straight(length=0.1, count=51, turn=0.0, start=TARGET):
    """Head poses along y of the head, with z turning by `turn` [rad] in all."""
    poses = np.tile(start, (count, 1, 1))
    share = np.linspace(0.0, 1.0, count)
    poses[:, :3, 3] += (length * (share - 0.5))[:, None] * start[:3, 1]
    poses[:, :3, :3] = start[:3, :3] @ Rotation.from_euler("y", (turn * share)[:, None]).as_matrix()
    return poses


def joints_at(pose):
    """Joints that hold the head at a pose, on the branch of the tests."""
    return nearest(ARM.solve_head(pose), TOUCH, ARM.limits)


def run(runner, most=3000):
    """Joints after every period until the end."""
    joints = [runner.path.at(runner.length)]
    while not runner.at_end:
        joints.append(runner.step())
        assert len(joints) < most
    return np.array(joints)
