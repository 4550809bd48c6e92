"""Choose the target pixel and the disc around it (section 3.2 and Fig. 5).

The target is the centre of the region's box, kept where it is as long as there is skin to fit. The
rules, in this order:

1. Skin is what `skin_layer` says, without the arm and without the edges of limbs.
2. A disc is good when at least 70 % of its pixels are skin. The disc has the wanted radius; where
   holes thin it out a disc of 1.4 times that radius is tried, at the edge of a limb one of 0.7 and
   of 0.5 times.
3. When none is good at the centre, or the surface in it cannot be fitted, the target moves to the
   nearest pixel where the smallest disc is good, and so on outwards.
"""

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_localize.errors import LocalizeError

Array = NDArray[np.float64]
FACTORS = (1.0, 1.4, 0.7, 0.5)  # radii tried, in units of the wanted one
_GOOD, _HOLES = 0.7, 0.45  # shares of a disc: good; worth a larger one
_PLACES = 8  # away from the centre at most


class NoSkinError(LocalizeError):
    """A region without a place to touch."""


class Disc(NamedTuple):
    """Target pixel (u, v) and radius, both [px] in the colour picture."""

    pixel: tuple[float, float]
    radius_px: float


def candidate_discs(
    skin: NDArray[np.bool_], u: Array, v: Array, centre: tuple[float, float], radius_px: float
) -> Iterator[Disc]:
    """Discs for a target by the rules above, the best first.

    Args:
        skin: Pixels that are skin, shape (h, w).
        u: Columns of these pixels in the picture [px], shape (w,), evenly spaced.
        v: Rows likewise, shape (h,).
        centre: Middle of the region's box (u, v) [px].
        radius_px: Wanted radius [px].

    Raises:
        NoSkinError: When no pixel of the region bears even the smallest disc.
    """
    if not skin.any():
        raise NoSkinError(
            "no depth on skin in the region; is it hidden, too near, or out of the depth camera's view?"
        )
    stride = float(u[1] - u[0]) if len(u) > 1 else float(v[1] - v[0]) if len(v) > 1 else 1.0
    shares = {factor: disc_share(skin, factor * radius_px / stride) for factor in FACTORS}
    at_centre = _good_factors(shares, (_cell(v, centre[1]), _cell(u, centre[0])))
    for factor in at_centre:
        yield Disc(centre, factor * radius_px)
    rows, columns = np.nonzero((shares[min(FACTORS)] >= _GOOD) & skin)
    if len(rows) == 0 and not at_centre:
        raise NoSkinError(
            f"no disc of {min(FACTORS) * radius_px:.0f} px in the region is filled with skin "
            f"({skin.mean():.0%} of it has depth); is the depth picture full of holes?"
        )
    places = np.column_stack([u[columns], v[rows]])
    apart = np.hypot(*(places - centre).T)
    if at_centre:
        apart[apart < 0.5 * radius_px] = np.inf
    for _ in range(_PLACES):
        if len(rows) == 0 or not np.isfinite(apart.min()):
            return
        nearest = int(np.argmin(apart))
        factor = _good_factors(shares, (int(rows[nearest]), int(columns[nearest])))[0]
        yield Disc((float(places[nearest, 0]), float(places[nearest, 1])), factor * radius_px)
        apart[np.hypot(*(places - places[nearest]).T) < 0.5 * radius_px] = np.inf


def disc_share(skin: NDArray[np.bool_], radius: float) -> Array:
    """Share of skin, shape (h, w), in the disc of `radius` [cells] around each cell; outside is none."""
    reach = max(int(radius), 1)
    grid = np.arange(-reach, reach + 1)
    kernel = (grid[:, None] ** 2 + grid[None, :] ** 2 <= max(radius, 1.0) ** 2).astype(np.float32)
    return cv2.filter2D(skin.astype(np.float32), -1, kernel / kernel.sum(), borderType=cv2.BORDER_CONSTANT)


def _cell(axis: Array, value: float) -> int:
    return int(np.argmin(np.abs(axis - value)))


def _good_factors(shares: dict[float, Array], place: tuple[int, int]) -> list[float]:
    """Factors of the discs to try at a cell, the best first; none when no disc is good."""
    wanted, larger, *smaller = FACTORS
    good = [wanted] if shares[wanted][place] >= _GOOD else []
    if not good and shares[wanted][place] >= _HOLES and shares[larger][place] >= _GOOD:
        good.append(larger)
    return good + [factor for factor in smaller if shares[factor][place] >= _GOOD]
