"""Planner, mask and clearance take any arm: an RM65, and a gantry that shares nothing with it."""

from dataclasses import replace

import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_from, transform_points
from bathbot_localize.arm.arm_mask import arm_silhouette, near_arm
from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.clearance import BodyClearance
from bathbot_scrub.arm.tool_path import densify, solve_path
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.path.reach import Reach
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from gantry_arm import BOOM, GantryArm
from numpy.testing import assert_allclose
from synthetic_skin import DISTANCE, cylinder, target

ARM, SETTINGS = GantryArm(), ScrubPlannerSettings()
CAMERA = Pinhole(212, 120, 106.0, 106.0, 105.8, 60.2)
ASIDE = transform_from(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]), (0.3, -1.2, 0.0))  # looks along y
AT_TARGET = nearest(ARM.solve_head(target()), ARM.home, ARM.limits)


def links(arm, joints):
    """T_base_link by name, the head's included."""
    frames = dict(zip(arm.link_names, arm.link_frames(joints), strict=True))
    return frames | {arm.tool.frame: arm.head(joints)}


@pytest.mark.parametrize("arm", [ARM, RM65()], ids=["gantry", "RM65"])
def test_an_arm_has_what_the_protocol_asks_for(arm):
    wanted = {name for name in vars(Arm) if not name.startswith("_")}
    assert wanted <= set(dir(arm))
    count, joints = len(arm.joint_names), arm.home
    assert arm.limits.contain(joints)
    assert arm.link_frames(joints).shape == (len(arm.link_names), 4, 4)
    assert_allclose(arm.link_frames(joints)[-1], arm.flange(joints))
    assert_allclose(arm.head(joints), arm.flange(joints) @ arm.tool.T_flange_head)
    assert {*arm.shape.links} <= {*arm.link_names, arm.tool.frame}
    assert arm.shape.flange == arm.link_names[-1]
    assert arm.solve_head(arm.head(joints)).shape[1:] == (count,)


@pytest.mark.parametrize("arm", [ARM, RM65()], ids=["gantry", "RM65"])
def test_its_solutions_hold_the_head_where_it_shall_be(arm):
    joints = arm.home + np.array([0.1, 0.1, 0.1, 0.2, -0.3, 0.2])
    pose = arm.head(joints)
    solutions = arm.solve_head(pose)
    found = solutions[np.isfinite(solutions).all(axis=-1)]
    assert_allclose(arm.head(found), np.broadcast_to(pose, (len(found), 4, 4)), atol=1e-9)
    assert_allclose(nearest(solutions, joints, arm.limits), joints, atol=1e-9)


def test_a_picture_is_masked_where_this_arm_is():
    places = links(ARM, AT_TARGET)
    mask = arm_silhouette(ARM.shape.capsules, places, ASIDE, CAMERA, 0.0)
    boom = transform_points(places["slide_z"], np.linspace(BOOM.start, BOOM.end, 20))
    u, v = np.rint(CAMERA.project(transform_points(inverse(ASIDE), boom))).astype(int).T
    assert mask[v, u].all()
    assert near_arm(boom, ARM.shape.capsules, places, 0.0).all()
    above = boom + np.array([0.0, 0.0, BOOM.radius + 0.05])
    u, v = np.rint(CAMERA.project(transform_points(inverse(ASIDE), above))).astype(int).T
    assert not mask[v, u].any()
    assert not near_arm(above, ARM.shape.capsules, places, 0.0).any()


def test_a_scrub_path_is_planned_that_this_arm_can_follow():
    task = Task(cylinder(), 0.0, target(), target(), AT_TARGET)
    planner = PathPlanner(task, SETTINGS, Reach(ARM, AT_TARGET))
    assert planner.reached > 0.95
    segments = []
    while not planner.finished:
        segments.append(planner.next_segment())
    poses = np.concatenate([segment.T_base_heads for segment in segments])
    assert len(poses) * SETTINGS.step > 0.3
    dense = densify(poses)[1]
    joints = solve_path(ARM, dense, AT_TARGET)
    assert_allclose(ARM.head(joints), dense, atol=1e-9)


def test_its_reach_bounds_the_path():
    """A slide that ends 1 cm above the target leaves only what lies below."""
    upper = ARM.limits.upper.copy()
    upper[2] = 0.01
    short = GantryArm(limits=replace(ARM.limits, upper=upper))
    planner = PathPlanner(
        Task(cylinder(), 0.0, target(), target(), AT_TARGET), SETTINGS, Reach(short, AT_TARGET)
    )
    assert planner.poses[:, 2, 3].max() <= 0.011
    assert planner.reached < 0.9


def test_a_body_behind_the_boom_keeps_this_arm_away():
    clearance = BodyClearance(ARM)
    beside = ARM.link_frames(AT_TARGET)[3, :3, 3] + (-0.3, 0.0, BOOM.radius + 0.008)
    assert not clearance.free(AT_TARGET[None], beside[None], 0.015)[0]
    assert clearance.free(AT_TARGET[None], beside[None] + (0.0, 0.0, 0.02), 0.015)[0]
    touched = np.array([[DISTANCE, 0.0, 0.0]])  # under the bristles: there the head may touch
    assert clearance.free(AT_TARGET[None], touched, 0.015)[0]
    assert not Reach(ARM, AT_TARGET, beside[None]).holds(target()[None], easily=True).any()
