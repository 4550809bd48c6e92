"""Cubic B-splines with even spacing, Eqs. (6)-(10)."""

import numpy as np
import pytest
from bathbot_scrub.path.bspline import (
    PathTooShortError,
    arc_length,
    chord_parameters,
    fit,
    parameters_at,
    resample,
    resample_first_order,
    tangents,
)
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose


def arc(radius, count=60, angle=2.0):
    phi = np.linspace(0.0, angle, count)
    return radius * np.column_stack([np.cos(phi), np.sin(phi), 0.1 * phi])


def wave(seed, count=40):
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 0.2, count)
    sines = [[rng.uniform(0, 0.01) * np.sin(k * 20.0 * x + rng.uniform(0, 6)) for k in (1, 2)] for _ in "yz"]
    return np.column_stack([x, *np.sum(sines, axis=1)])


@given(seed=st.integers(0, 1000))
def test_curve_passes_through_its_points(seed):
    points = wave(seed)
    assert_allclose(fit(points)(chord_parameters(points)), points, atol=1e-12)


@given(radius=st.floats(0.02, 0.5), step=st.floats(0.001, 0.004))
def test_spacing_is_the_step_exactly(radius, step):
    """Neighbours on the curve are one step of arc length apart, to 1 nm."""
    curve = fit(arc(radius))
    points = resample(curve, step)
    along = arc_length(curve)
    mu = parameters_at(curve, step * np.arange(len(points)), along)
    fine = np.linspace(mu[:-1], mu[1:], 200)
    lengths = np.linalg.norm(np.diff(curve(fine), axis=0), axis=2).sum(axis=0)
    assert_allclose(lengths, step, rtol=1e-5)
    assert along.total - step < step * (len(points) - 1) <= along.total + 1e-9


def test_arc_length_of_a_helix():
    """Length of r (cos, sin, 0.1 phi) over 2 rad is 2 r sqrt(1.01)."""
    assert arc_length(fit(arc(0.15, 200))).total == pytest.approx(2.0 * 0.15 * np.sqrt(1.01), rel=1e-7)


@given(seed=st.integers(0, 1000))
def test_first_order_rule_is_exact_on_straight_lines_only(seed):
    """Eqs. (9)-(10) as printed: the spacing drifts where the parameter's speed does."""
    line = fit(np.outer(np.linspace(0.0, 0.1, 9), [0.6, 0.0, 0.8]))
    spacing = np.linalg.norm(np.diff(resample_first_order(line, 0.002), axis=0), axis=1)
    assert_allclose(spacing, 0.002, rtol=1e-9)
    curve = fit(wave(seed)[np.sort(np.random.default_rng(seed).choice(40, 12, replace=False))])
    printed = resample_first_order(curve, 0.01)
    exact = resample(curve, 0.01)
    gap = min(len(printed), len(exact)) - 1
    assert np.linalg.norm(printed[gap] - exact[gap]) < 0.01
    finer = resample_first_order(curve, 0.001)[::10]
    shared = min(len(finer), len(exact), len(printed))
    drift = [np.linalg.norm(path[:shared] - exact[:shared], axis=1).max() for path in (printed, finer)]
    assert drift[1] <= 0.3 * drift[0] + 1e-7


@given(seed=st.integers(0, 1000))
def test_tangents_equal_finite_differences(seed):
    curve, mu, step = fit(wave(seed)), np.linspace(0.01, 0.99, 31), 1e-6
    difference = curve(mu + step) - curve(mu - step)
    difference /= np.linalg.norm(difference, axis=1, keepdims=True)
    assert_allclose(tangents(curve, mu), difference, atol=1e-6)


@given(seed=st.integers(0, 1000))
def test_resampling_moves_with_the_curve(seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shift = rng.normal(size=3)
    points = wave(seed)
    moved = resample(fit(points @ turn.T + shift), 0.002)
    assert_allclose(moved, resample(fit(points), 0.002) @ turn.T + shift, atol=1e-9)


def test_start_tangent_is_kept():
    curve = fit(arc(0.1, 12), start_tangent=(0.3, 1.0, 0.0))
    assert_allclose(tangents(curve, 0.0), np.array([0.3, 1.0, 0.0]) / np.hypot(0.3, 1.0), atol=1e-9)


@pytest.mark.parametrize("points", [[[0, 0, 0]], [[0, 0, 0], [0, 0, 0]]], ids=["one", "equal"])
def test_too_few_points_are_refused(points):
    with pytest.raises(PathTooShortError, match="at least two points"):
        fit(np.array(points, dtype=float))


def test_two_points_give_a_straight_line():
    assert_allclose(resample(fit([[0, 0, 0], [0.01, 0, 0]]), 0.005)[:, 0], [0.0, 0.005, 0.01], atol=1e-12)
