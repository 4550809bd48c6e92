"""Normals by Fig. 6 and Eqs. (11)-(13): shapes whose normals are known, and invariance."""

import numpy as np
import pytest
from bathbot_scrub.path.triangle_normals import triangle_normals
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from synthetic_skin import somewhere

X, Y = np.meshgrid(np.arange(-30, 31) * 0.002, np.arange(-20, 21) * 0.002)
SHAPES = {
    "plane": 0.3 * X - 0.2 * Y,
    "cylinder": np.sqrt(0.15**2 - Y**2) - 0.15,
    "sphere": np.sqrt(0.12**2 - X**2 - Y**2) - 0.12,
}


def true_normals(shape):
    if shape == "plane":
        slope = np.broadcast_to([-0.3, 0.2, 1.0], (*X.shape, 3))
    elif shape == "cylinder":
        slope = np.stack([0 * X, Y, SHAPES[shape] + 0.15], axis=-1)
    else:
        slope = np.stack([X, Y, SHAPES[shape] + 0.12], axis=-1)
    return slope / np.linalg.norm(slope, axis=-1, keepdims=True)


def angles_deg(one, other):
    return np.degrees(np.arccos(np.clip(np.sum(one * other, axis=-1), -1.0, 1.0)))


@pytest.mark.parametrize(
    ("shape", "inner", "border"), [("plane", 1e-5, 1e-5), ("cylinder", 0.1, 1.5), ("sphere", 0.1, 1.5)]
)
def test_normals_of_known_shapes(shape, inner, border):
    normals = triangle_normals(np.stack([X, Y, SHAPES[shape]], axis=-1), (0, 0, 1))
    error = angles_deg(normals, true_normals(shape))
    assert error[1:-1, 1:-1].max() < inner
    assert error.max() < border


@given(seed=st.integers(0, 500))
def test_normals_turn_with_the_surface(seed):
    move = somewhere(seed)
    points = np.stack([X, Y, SHAPES["sphere"]], axis=-1)[::4, ::4]
    turned = triangle_normals(points @ move[:3, :3].T + move[:3, 3], move[:3, 2])
    assert_allclose(turned, triangle_normals(points, (0, 0, 1)) @ move[:3, :3].T, atol=1e-9)


@given(seed=st.integers(0, 500))
def test_normals_point_to_the_viewer_and_have_length_one(seed):
    points = np.stack([X, Y, SHAPES["sphere"]], axis=-1)[::4, ::4]
    viewpoint = np.random.default_rng(seed).uniform([-0.1, -0.1, 0.3], [0.1, 0.1, 0.5])
    normals = triangle_normals(points[:, ::-1], viewpoint - points[:, ::-1])
    assert np.all(np.sum(normals * (viewpoint - points[:, ::-1]), axis=-1) > 0.0)
    assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)


def test_a_missing_point_is_left_out():
    points = np.stack([X, Y, SHAPES["sphere"]], axis=-1)
    points[10, 10] = np.nan
    normals = triangle_normals(points, (0, 0, 1))
    assert np.isnan(normals[10, 10]).all()
    near = np.s_[9:12, 9:12]
    assert angles_deg(normals[near], true_normals("sphere")[near])[[0, 0, 1], [0, 1, 0]].max() < 1.5


def test_areas_weight_the_triangles():
    """A spoke four times as long: its two triangles count four times; by hand, Eqs. (11)-(13)."""
    points = np.full((3, 3, 3), np.nan)
    points[1, 1], points[1, 2], points[0, 1] = (0, 0, 0), (4, 0, 0), (0, 1, 0)
    points[1, 0], points[2, 1] = (-1, 0, 1), (0, -1, 0)
    normal = triangle_normals(points, (0, 0, 1))[1, 1]
    total = np.array([0, 0, 4.0]) + np.array([1, 0, 1.0]) + np.array([1, 0, 1.0]) + np.array([0, 0, 4.0])
    assert_allclose(normal, total / np.linalg.norm(total))
