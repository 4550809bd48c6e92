"""The smooth height field."""

import numpy as np
import pytest
from bathbot_scrub.path.height_field import HeightField, smooth
from bathbot_scrub.path.patch import Cells, PatchGrid
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

GRID = PatchGrid(np.eye(4), 0.08, 0.06, 0.004)
X, Y = np.meshgrid(GRID.x, GRID.y)
INNER = (slice(6, -6), slice(6, -6))


def cells(height, known=None):
    known = np.ones(height.shape, dtype=bool) if known is None else known
    return Cells(np.where(known, height, np.nan), known.astype(float))


@settings(max_examples=30)
@given(st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6))
def test_quadratics_pass_unchanged(factors):
    a, b, c, d, e, f = factors
    height = 0.01 * a + 0.1 * (b * X + c * Y) + d * X**2 + e * X * Y + f * Y**2
    assert_allclose(smooth(cells(height), 2.5)[INNER], height[INNER], atol=1e-5)


def test_noise_shrinks_tenfold_and_a_limb_does_not_sink():
    """1 mm of noise on a limb of 70 mm radius: a Gaussian mean of that width would sink it by 0.7 mm."""
    limb = np.sqrt(0.07**2 - Y**2) - 0.07
    noise = 0.001 * np.random.default_rng(1).normal(size=X.shape)
    error = (smooth(cells(limb + noise), 2.5) - limb)[8:-8, 6:-6]
    assert np.sqrt(np.mean(error**2)) < 0.0003
    assert abs(error.mean()) < 0.0001


def test_far_from_all_cells_nothing_is_made_up():
    known = X < 0.0
    fitted = smooth(cells(0.0 * X, known), 2.5)
    assert np.isnan(fitted[:, -5:]).all()
    assert np.isfinite(fitted[:, :20]).all()


def test_field_between_nodes():
    height = np.sqrt(0.15**2 - X**2) - 0.15
    field = HeightField(GRID, height, np.ones(X.shape, dtype=bool))
    plane = np.random.default_rng(2).uniform(-0.05, 0.05, size=(50, 2))
    points = field.points_at(plane)
    assert_allclose(points[:, 2], np.sqrt(0.15**2 - plane[:, 0] ** 2) - 0.15, atol=1e-7)
    normals = np.column_stack([plane[:, 0], 0 * plane[:, 0], points[:, 2] + 0.15]) / 0.15
    assert np.degrees(np.arccos(np.sum(field.normals_at(plane) * normals, axis=1).clip(-1, 1))).max() < 0.1


def test_transposed_field_is_the_mirror():
    height = 0.2 * X + X * Y
    field = HeightField(GRID, height, np.ones(X.shape, dtype=bool))
    plane = np.array([[0.02, -0.01], [0.0, 0.03]])
    other = field.transposed().points_at(plane[:, ::-1])
    assert_allclose(other[:, [1, 0, 2]], field.points_at(plane), atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["hollow", "bump"])
def test_relief_of_a_ball_is_its_sagitta(sign):
    """A bowl of radius R rises by R - sqrt(R^2 - r^2) at distance r from its deepest point; a ball falls."""
    grid = PatchGrid(np.eye(4), 0.06, 0.06, 0.004)
    x, y = np.meshgrid(grid.x, grid.y)
    height = sign * (0.1 - np.sqrt(0.1**2 - x**2 - y**2))
    field = HeightField(grid, height, np.ones(x.shape, dtype=bool))
    assert field.relief_at([[0.0, 0.0]], 0.02)[0] == pytest.approx(
        sign * (0.1 - np.sqrt(0.1**2 - 0.02**2)), abs=1e-4
    )
