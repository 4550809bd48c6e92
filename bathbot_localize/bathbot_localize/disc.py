"""Choose the target pixel and the disc around it (section 3.2 and Fig. 5).

The target is the centre of the region's box, kept where it is as long as there is skin to fit. The
rules, in this order:

1. Skin is the front layer: what stands before the first gap in depth inside the box, without the
   arm. What lies behind a limb is not skin of this region.
2. A disc is good when at least 70 % of its pixels are skin. The disc has the wanted radius; where
   holes thin it out a disc of 1.4 times that radius is tried, at the edge of a limb one of 0.7 and
   of 0.5 times.
3. When none is good at the centre, the target moves to the nearest pixel where the smallest one is.
"""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_localize.errors import LocalizeError

Array = NDArray[np.float64]
FACTORS = (1.0, 1.4, 0.7, 0.5)   # radii tried, in units of the wanted one
_GOOD, _HOLES = 0.7, 0.45        # shares of a disc: good; worth a larger one
_BIN, _GAP = 0.02, 3             # [m] and bins: an empty band of 60 mm parts two layers
_FEW = 0.005                     # share of the points below which a bin counts as empty
_LAYER = 0.05                    # share of the points a layer must hold


class NoSkinError(LocalizeError):
    """A region without a place to touch."""


class Disc(NamedTuple):
    """Target pixel (u, v) and radius, both [px] in the colour picture."""

    pixel: tuple[float, float]
    radius_px: float


def front_layer(depth: Array) -> NDArray[np.bool_]:
    """Pixels of the first layer of depth [m], shape (h, w), seen from the camera; NaN belongs to none."""
    layer = np.isfinite(depth)
    values = depth[layer]
    if values.size == 0:
        return layer
    first = float(values.min())
    counts = np.bincount(((values - first) / _BIN).astype(int))
    filled = counts > _FEW * values.size
    begin = held = 0
    for index in range(len(counts)):
        held += counts[index] if filled[index] else 0
        if not filled[index : index + _GAP].any():
            if held >= _LAYER * values.size:
                return layer & (depth < first + _BIN * index) & (depth >= first + _BIN * begin)
            begin, held = index + 1, 0
    return layer & (depth >= first + _BIN * begin)


def choose_disc(
    skin: NDArray[np.bool_], u: Array, v: Array, centre: tuple[float, float], radius_px: float
) -> Disc:
    """Place the disc of a target by the rules above.

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
        raise NoSkinError("no depth on skin in the region; is it hidden, too near, or out of the depth camera's view?")
    stride = float(u[1] - u[0]) if len(u) > 1 else float(v[1] - v[0]) if len(v) > 1 else 1.0
    shares = {factor: disc_share(skin, factor * radius_px / stride) for factor in FACTORS}
    place = _cell(v, centre[1]), _cell(u, centre[0])
    factor = _factor_at(shares, place)
    if factor > 0.0:
        return Disc(centre, factor * radius_px)
    rows, columns = np.nonzero((shares[min(FACTORS)] >= _GOOD) & skin)
    if len(rows) == 0:
        raise NoSkinError(
            f"no disc of {min(FACTORS) * radius_px:.0f} px in the region is filled with skin "
            f"({skin.mean():.0%} of it has depth); is the depth picture full of holes?"
        )
    nearest = np.argmin(np.hypot(v[rows] - centre[1], u[columns] - centre[0]))
    place = int(rows[nearest]), int(columns[nearest])
    return Disc((float(u[place[1]]), float(v[place[0]])), _factor_at(shares, place) * radius_px)


def disc_share(skin: NDArray[np.bool_], radius: float) -> Array:
    """Share of skin, shape (h, w), in the disc of `radius` [cells] around each cell; beyond the border is none."""
    reach = max(int(radius), 1)
    grid = np.arange(-reach, reach + 1)
    kernel = (grid[:, None] ** 2 + grid[None, :] ** 2 <= max(radius, 1.0) ** 2).astype(np.float32)
    return cv2.filter2D(skin.astype(np.float32), -1, kernel / kernel.sum(), borderType=cv2.BORDER_CONSTANT)


def _cell(axis: Array, value: float) -> int:
    return int(np.argmin(np.abs(axis - value)))


def _factor_at(shares: dict[float, Array], place: tuple[int, int]) -> float:
    """Factor of the disc to take at a cell; 0 when none is good."""
    wanted, larger, *smaller = FACTORS
    if shares[wanted][place] >= _GOOD:
        return wanted
    if shares[wanted][place] >= _HOLES and shares[larger][place] >= _GOOD:
        return larger
    return next((factor for factor in smaller if shares[factor][place] >= _GOOD), 0.0)
