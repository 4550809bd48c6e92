import numpy as np
from bathbot_depthcorr.geometry.rigid import (
    inverse,
    quaternion_from_rotation,
    rotate,
    rotation_angle,
    rotation_from_quaternion,
    transform_from,
    transform_points,
)
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

angles = st.floats(-3.1, 3.1)
lengths = st.floats(-5.0, 5.0)
vectors = st.tuples(lengths, lengths, lengths)
transforms = st.builds(
    lambda turn, shift: transform_from(Rotation.from_rotvec(turn).as_matrix(), shift),
    st.tuples(angles, angles, angles), vectors,
)  # fmt: skip


@given(transform=transforms)
def test_inverse_undoes(transform):
    assert_allclose(inverse(transform) @ transform, np.eye(4), atol=1e-12)
    assert_allclose(inverse(inverse(transform)), transform, atol=1e-12)


@given(first=transforms, second=transforms, point=vectors)
def test_transforms_chain_as_they_read(first, second, point):
    assert_allclose(
        transform_points(first @ second, point),
        transform_points(first, transform_points(second, point)),
        atol=1e-9,
    )


@given(transform=transforms, a=vectors, b=vectors)
def test_distances_survive(transform, a, b):
    moved = transform_points(transform, np.array([a, b]))
    assert_allclose(np.linalg.norm(moved[0] - moved[1]), np.linalg.norm(np.subtract(a, b)), atol=1e-9)


@given(transform=transforms, a=vectors, b=vectors)
def test_vectors_do_not_translate(transform, a, b):
    difference = transform_points(transform, a) - transform_points(transform, b)
    assert_allclose(rotate(transform, np.subtract(a, b)), difference, atol=1e-9)


@given(transform=transforms)
def test_quaternion_round_trip_has_a_positive_scalar(transform):
    quaternion = quaternion_from_rotation(transform[:3, :3])
    assert quaternion[3] >= 0.0
    assert_allclose(rotation_from_quaternion(quaternion), transform[:3, :3], atol=1e-12)


def test_quarter_turn_about_z_takes_x_to_y():
    quaternion = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))
    assert_allclose(rotation_from_quaternion(quaternion) @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-12)
    assert_allclose(rotation_angle(rotation_from_quaternion(quaternion)), np.pi / 2)


def test_inverse_of_a_stack():
    stack = np.stack(
        [transform_from(translation=(1, 2, 3)), transform_from(Rotation.from_rotvec((0, 0, 1)).as_matrix())]
    )
    assert_allclose(inverse(stack) @ stack, np.broadcast_to(np.eye(4), (2, 4, 4)), atol=1e-12)
