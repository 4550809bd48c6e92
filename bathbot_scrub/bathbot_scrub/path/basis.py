"""The B-spline basis of Eqs. (7)-(8), written out as a reference for scipy's.

Two things differ from the print, and both printed forms are kept beside the right ones:

* Eq. (7) closes both ends of a knot span, so the basis sums to two at interior knots; we close the
  left end only (and the right end of the last span, so that the curve has an end point).
* Eq. (8) lacks the factor k and a bracket around the difference; it is k times too small.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def basis(knots: ArrayLike, degree: int, mu: ArrayLike) -> Array:
    """Basis functions N_j,k of Eq. (7), closed at the left end of each span.

    Args:
        knots: Knot vector U, ascending, shape (m + 1,).
        degree: Degree k.
        mu: Parameters, shape (M,).

    Returns:
        N_j,k(mu), shape (M, m - k).
    """
    knots, mu = np.asarray(knots, dtype=float), np.asarray(mu, dtype=float)[:, None]
    inside = (knots[:-1] <= mu) & (mu < knots[1:])
    last = np.flatnonzero(knots[:-1] < knots[1:])[-1]
    inside[:, last] |= mu[:, 0] == knots[last + 1]
    return _raise_degree(knots, degree, mu, inside.astype(float))


def basis_as_printed(knots: ArrayLike, degree: int, mu: ArrayLike) -> Array:
    """Basis functions of Eq. (7) to the letter: spans closed at both ends. Shapes as `basis`."""
    knots, mu = np.asarray(knots, dtype=float), np.asarray(mu, dtype=float)[:, None]
    inside = (knots[:-1] <= mu) & (mu <= knots[1:]) & (knots[:-1] < knots[1:])
    return _raise_degree(knots, degree, mu, inside.astype(float))


def basis_derivative(knots: ArrayLike, degree: int, mu: ArrayLike) -> Array:
    """Derivatives dN_j,k/dmu, shape (M, m - k): Eq. (8) with the factor k and the bracket."""
    return degree * basis_derivative_as_printed(knots, degree, mu)


def basis_derivative_as_printed(knots: ArrayLike, degree: int, mu: ArrayLike) -> Array:
    """Derivatives by Eq. (8) with the bracket but without the factor k, shape (M, m - k)."""
    knots = np.asarray(knots, dtype=float)
    lower = basis(knots, degree - 1, mu)
    count = lower.shape[1] - 1
    left = _ratio(np.ones(count), knots[degree : degree + count] - knots[:count])
    right = _ratio(np.ones(count), knots[degree + 1 : degree + 1 + count] - knots[1 : count + 1])
    return lower[:, :-1] * left - lower[:, 1:] * right


def _raise_degree(knots: Array, degree: int, mu: Array, values: Array) -> Array:
    """Apply the recursion of Eq. (7) to N_j,0, shape (M, m), until the wanted degree."""
    for k in range(1, degree + 1):
        count = values.shape[1] - 1
        left = _ratio(mu - knots[:count], knots[k : k + count] - knots[:count])
        right = _ratio(knots[k + 1 : k + 1 + count] - mu, knots[k + 1 : k + 1 + count] - knots[1 : count + 1])
        values = left * values[:, :-1] + right * values[:, 1:]
    return values


def _ratio(numerator: Array, denominator: Array) -> Array:
    """Quotient with 0/0 = 0, as Eq. (7) sets it."""
    return numerator * np.divide(1.0, denominator, out=np.zeros_like(denominator), where=denominator > 0.0)
