"""The basis of Eqs. (7)-(8): laws, scipy as the oracle, and what the print gets wrong."""

import numpy as np
import pytest
from bathbot_scrub.path.basis import basis, basis_as_printed, basis_derivative, basis_derivative_as_printed
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline

INNER = st.lists(st.floats(0.05, 0.95), min_size=0, max_size=6, unique=True)


def clamped(inner, degree=3):
    return np.concatenate([np.zeros(degree + 1), np.sort(inner), np.ones(degree + 1)])


@given(inner=INNER, degree=st.integers(1, 4))
def test_basis_sums_to_one_everywhere(inner, degree):
    knots = clamped(inner, degree)
    mu = np.concatenate([np.linspace(0.0, 1.0, 41), knots])
    assert_allclose(basis(knots, degree, mu).sum(axis=1), 1.0, atol=1e-12)


@given(inner=INNER)
def test_basis_equals_scipys(inner):
    knots = clamped(inner)
    mu = np.linspace(0.0, 1.0, 57)
    assert_allclose(basis(knots, 3, mu), BSpline.design_matrix(mu, knots, 3).toarray(), atol=1e-12)


def test_printed_basis_counts_interior_knots_twice():
    knots = clamped([0.25, 0.5])
    assert_allclose(basis_as_printed(knots, 0, knots[4:6]).sum(axis=1), 2.0)
    assert_allclose(basis_as_printed(knots, 3, [0.1, 0.3, 0.7]).sum(axis=1), 1.0)


@given(inner=st.lists(st.floats(0.1, 0.9), min_size=1, max_size=4, unique_by=lambda x: round(x, 1)))
def test_derivative_equals_finite_difference(inner):
    knots, mu, step = clamped(inner), np.linspace(0.013, 0.983, 23), 1e-6
    mu = mu[np.min(np.abs(mu[:, None] - knots), axis=1) > 1e-4]
    difference = (basis(knots, 3, mu + step) - basis(knots, 3, mu - step)) / (2 * step)
    assert_allclose(basis_derivative(knots, 3, mu), difference, atol=1e-5 * np.abs(difference).max())


def test_printed_derivative_lacks_the_factor_three():
    knots, mu = clamped([0.4]), np.linspace(0.05, 0.95, 7)
    printed = basis_derivative_as_printed(knots, 3, mu)
    assert_allclose(3.0 * printed, basis_derivative(knots, 3, mu))


def test_hand_computed_quadratic():
    """One span, degree 2: the Bernstein polynomials (1-t)^2, 2t(1-t), t^2."""
    assert_allclose(basis([0, 0, 0, 1, 1, 1], 2, [0.25]), [[0.5625, 0.375, 0.0625]])


@pytest.mark.parametrize("end", [0.0, 1.0])
def test_curve_has_both_end_points(end):
    row = basis(clamped([0.5]), 3, [end])[0]
    assert_allclose(row, np.eye(len(row))[0 if end == 0.0 else -1])
