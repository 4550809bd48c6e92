"""Poses of the scrub head, Eqs. (14)-(18)."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import rotation_angle
from bathbot_scrub.path.tool_pose import (
    TURN_THRESHOLD,
    Turning,
    flange_poses,
    head_poses,
    head_rotations,
    held_rotations,
    rotation_rates,
    step_angles,
    turned_rotations,
    turns,
    turns_as_printed,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

VECTORS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


def cylinder_path(radius=0.15, step=0.002, angle=1.2, skew=0.3):
    """Points, normals and tangents of a helix on a cylinder."""
    phi = np.arange(0.0, angle, step / (radius * np.hypot(1.0, skew)))
    normals = np.column_stack([np.cos(phi), np.sin(phi), 0 * phi])
    travel = np.column_stack([-np.sin(phi), np.cos(phi), skew + 0 * phi])
    return radius * normals + np.outer(phi, [0, 0, radius * skew]), normals, travel


def angle_between(one, other):
    return rotation_angle(np.swapaxes(one, -1, -2) @ other)


@given(normal=VECTORS, travel=VECTORS)
def test_rotation_is_proper_with_z_into_the_skin_and_y_along_travel(normal, travel):
    assume(np.linalg.norm(normal) > 0.1)
    normal = normal / np.linalg.norm(normal)
    along = travel - (travel @ normal) * normal
    assume(np.linalg.norm(along) > 0.05)
    rotation = head_rotations(normal, travel)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-9)
    assert rotation[:, 2] @ normal == pytest.approx(-1.0)
    assert rotation[:, 1] @ travel > 0.0
    assert rotation[:, 1] @ normal == pytest.approx(0.0, abs=1e-9)


def test_columns_are_those_of_equation_14():
    """Normal up, travel along x: a = -z, o = x, m = K x I = y x z."""
    rotation = head_rotations([0, 0, 1], [1, 0, 0])
    assert_allclose(rotation, np.column_stack([np.cross([1, 0, 0], [0, 0, -1]), [1, 0, 0], [0, 0, -1]]))


def test_flange_stands_a_head_behind_the_tip():
    pose = head_poses(head_rotations([-1, 0, 0], [0, 0, 1]), [0.5, 0.1, 0.3])
    assert_allclose(flange_poses(pose)[:3, 3], [0.4, 0.1, 0.3])
    assert_allclose(flange_poses(pose)[:3, :3], pose[:3, :3])


def test_printed_rule_never_turns_on_a_smooth_arc():
    points, normals, travel = cylinder_path()
    assert step_angles(points).max() < TURN_THRESHOLD
    assert len(turns_as_printed(points)) == 0
    rotations = head_rotations(normals, travel)
    assert angle_between(rotations[0], rotations[-1]) > np.radians(50.0)
    assert len(turns(rotations, rotations[0])) >= 8


def test_printed_rule_turns_at_a_corner():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]])
    assert_allclose(step_angles(points), [0.0, np.pi / 2])
    assert turns_as_printed(points).tolist() == [2]


@given(radius=st.floats(0.03, 0.4), skew=st.floats(-1.0, 1.0), threshold=st.floats(2.0, 12.0))
def test_held_head_is_never_off_by_more_than_the_threshold(radius, skew, threshold):
    _, normals, travel = cylinder_path(radius, skew=skew)
    rotations = head_rotations(normals, travel)
    held = held_rotations(rotations, rotations[0], np.radians(threshold))
    assert np.degrees(angle_between(held, rotations)).max() <= threshold + 1e-6


@given(radius=st.floats(0.03, 0.4), skew=st.floats(-1.0, 1.0))
def test_turning_head_is_never_off_by_more_than_the_threshold(radius, skew):
    _, normals, travel = cylinder_path(radius, skew=skew)
    rotations = head_rotations(normals, travel)
    rates = rotation_rates(rotations)
    start = Turning(rotations[0], rates[0])
    turned = turned_rotations(rotations[1:], start, rates[1:])
    assert np.degrees(angle_between(turned, rotations[1:])).max() <= 6.0
    assert_allclose(turned[-1], rotations[-1], atol=1e-9)


def test_turning_head_has_no_jumps_of_rate():
    """The rate changes from step to step by less than a tenth of what holding and jumping would do."""
    _, normals, travel = cylinder_path(0.1)
    rotations = head_rotations(normals, travel)
    rates = rotation_rates(rotations)
    jolts = []
    start = Turning(rotations[0], 0 * rates[0])
    for path in (held_rotations(rotations, rotations[0]), turned_rotations(rotations, start, rates)):
        steps = Rotation.from_matrix(np.swapaxes(path[:-1], -1, -2) @ path[1:]).as_rotvec()
        jolts.append(np.linalg.norm(np.diff(steps[10:], axis=0), axis=1).max())
    assert jolts[1] < 0.1 * jolts[0]


def test_rates_of_an_even_turn():
    rotations = Rotation.from_rotvec(np.outer(np.arange(6), [0.0, 0.0, 0.02])).as_matrix()
    assert_allclose(rotation_rates(rotations), np.tile([0, 0, 0.02], (6, 1)), atol=1e-12)
