"""Cubic B-spline paths with even spacing, Eqs. (6)-(10).

Eqs. (6)-(7), the curve and its basis, are `scipy.interpolate.BSpline` (`basis.py` holds them as
printed, as a reference). Two things differ from the print:

* Eq. (8) lacks the factor k and a bracket; without k Eq. (9) steps k times too far. We take the
  true derivative.
* Eqs. (9)-(10) are first order in the step, so the spacing drifts where the path bends, and
  Eq. (10) reuses its index inside the sum. `resample` finds the exact arc length instead;
  `resample_first_order` keeps the printed rule (with the true derivative) as a tested reference.

Symbols: mu is the curve parameter (no unit) on [0, 1], l the spacing `step` [m].
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline, make_interp_spline

from bathbot_scrub.errors import ScrubError

Array = NDArray[np.float64]
DEGREE = 3
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_NEWTON_STEPS = 12


class PathTooShortError(ScrubError):
    """Points that determine no curve."""


class ArcLength(NamedTuple):
    """Length of a curve from its start to each of its knots.

    Attributes:
        mu: Knots, shape (K,), ascending.
        length: Length up to each of them [m], shape (K,).
    """

    mu: Array
    length: Array

    @property
    def total(self) -> float:
        """Length of the whole curve [m]."""
        return float(self.length[-1])


def fit(points: ArrayLike, start_tangent: ArrayLike | None = None) -> BSpline:
    """Interpolate points by a cubic B-spline, Eq. (6), parametrised on [0, 1] by chord length.

    Args:
        points: Points in order [m], shape (N, 3), N >= 2, neighbours distinct.
        start_tangent: Direction at the first point, any length, shape (3,); free when omitted.

    Raises:
        PathTooShortError: When fewer than two distinct points are left.
    """
    points = np.asarray(points, dtype=float)
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 2 or not np.all(chords > 0.0):
        raise PathTooShortError(
            f"cannot lay a curve through {len(points)} points with shortest step "
            f"{np.min(chords, initial=np.inf):.2e} m; give at least two points, all distinct"
        )
    total, mu = chords.sum(), chord_parameters(points)
    if start_tangent is None:
        ends = "not-a-knot" if len(points) > DEGREE else "natural"
    else:
        direction = np.asarray(start_tangent, dtype=float)
        ends = ([(1, direction / np.linalg.norm(direction) * total)], [(2, np.zeros(3))])
    return make_interp_spline(mu, points, k=DEGREE, bc_type=ends)


def chord_parameters(points: ArrayLike) -> Array:
    """Parameters mu at which `fit` passes through points, shape (N, 3) -> (N,): chord length over its sum."""
    along = np.cumsum(np.linalg.norm(np.diff(np.asarray(points, dtype=float), axis=0), axis=1))
    return np.concatenate([[0.0], along[:-1] / along[-1], [1.0]])


def tangents(curve: BSpline, mu: ArrayLike) -> Array:
    """Unit tangents at parameters mu, shape (...) -> (..., 3), by Eq. (8) corrected."""
    derivative = curve(mu, nu=1)
    return derivative / np.linalg.norm(derivative, axis=-1, keepdims=True)


def arc_length(curve: BSpline) -> ArcLength:
    """Integrate |dp/dmu| between the knots, by Gauss-Legendre quadrature with 8 nodes."""
    mu = np.unique(np.clip(curve.t, 0.0, 1.0))
    pieces = _length_between(curve, mu[:-1], mu[1:])
    return ArcLength(mu, np.concatenate([[0.0], np.cumsum(pieces)]))


def parameters_at(curve: BSpline, lengths: ArrayLike, along: ArcLength | None = None) -> Array:
    """Parameters mu at which the curve has the given lengths [m], shape (M,): Eqs. (9)-(10), exact.

    Newton's method inside the knot span that holds each length.
    """
    along = arc_length(curve) if along is None else along
    lengths = np.clip(np.asarray(lengths, dtype=float), 0.0, along.total)
    span = np.clip(np.searchsorted(along.length, lengths, side="right") - 1, 0, len(along.mu) - 2)
    low, high = along.mu[span], along.mu[span + 1]
    wanted = lengths - along.length[span]
    mu = low + (high - low) * wanted / (along.length[span + 1] - along.length[span])
    for _ in range(_NEWTON_STEPS):
        excess = _length_between(curve, low, mu) - wanted
        mu = np.clip(mu - excess / np.linalg.norm(curve(mu, nu=1), axis=-1), low, high)
        if np.max(np.abs(excess), initial=0.0) < 1e-12:
            break
    return mu


def resample(curve: BSpline, step: float, start: float = 0.0) -> Array:
    """Points of a curve at equal steps of arc length.

    Args:
        curve: Path [m], parametrised on [0, 1].
        step: Spacing l along the curve [m], positive.
        start: Length before the first point [m].

    Returns:
        Points [m], shape (M, 3): all that fit; the end of the curve only when it falls on a step.
    """
    along = arc_length(curve)
    count = int(np.floor((along.total - start) / step + 1e-9)) + 1
    return np.asarray(curve(parameters_at(curve, start + step * np.arange(max(count, 0)), along)))


def resample_first_order(curve: BSpline, step: float) -> Array:
    """Points of a curve by Eqs. (9)-(10) as printed, with the true derivative: first order in `step` [m].

    Returns points [m], shape (M, 3). Exact on straight lines only; kept as a reference.
    """
    mu = [0.0]
    while (following := mu[-1] + step / float(np.linalg.norm(curve(mu[-1], nu=1)))) <= 1.0:
        mu.append(following)
    return np.asarray(curve(np.array(mu)))


def _length_between(curve: BSpline, low: Array, high: Array) -> Array:
    """Length of the curve [m] between pairs of parameters, shapes (M,), each inside one knot span."""
    half = 0.5 * (high - low)
    mu = (0.5 * (high + low))[:, None] + half[:, None] * _NODES
    return half * (np.linalg.norm(curve(mu, nu=1), axis=-1) @ _WEIGHTS)
