"""Boustrophedon scan lines over a patch of skin, starting where the arm already touches it.

The lines run along x of the patch frame, 0.8 brush diameters apart *on the skin*. From the target
the path follows its own line to one side, turns to an outermost line, and goes back and forth to
the other side. Each turn bends evenly more and then evenly less: a half circle would ask the wrist
to turn at full rate from one point to the next. Where a line or a turn would leave the allowed
skin, the path turns earlier or leaves the line out.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import cumulative_trapezoid

from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import Mask, PatchGrid

Array = NDArray[np.float64]
STEP = 0.001  # between points of the plane path [m]
_WIDE = 1.25  # a gap this many times wider than the spacing has a straight part in its turn


class ScanPath(NamedTuple):
    """A path in the plane of the patch.

    Attributes:
        plane: Positions (x, y) [m], shape (N, 2), from the target, about 1 mm apart.
        lines: Number of scan lines it holds.
    """

    plane: Array
    lines: int

    @property
    def lengths(self) -> Array:
        """Length in the plane up to each position [m], shape (N,)."""
        steps = np.linalg.norm(np.diff(self.plane, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


class Ground(NamedTuple):
    """Where the middle of the brush may go.

    Attributes:
        grid: Cells of the patch.
        allowed: One flag for each cell, shape (rows, columns).
    """

    grid: PatchGrid
    allowed: Mask

    def bears(self, plane: ArrayLike) -> Mask:
        """Whether positions (x, y) [m], shape (N, 2), lie on allowed cells, shape (N,)."""
        row, column, inside = self.grid.cells_of(plane)
        return inside & self.allowed[row, column]


def skin_distance(field: HeightField) -> tuple[Array, Array]:
    """Signed lengths on the skin from the middle row and column [m], both of shape (rows, columns).

    The first runs along x within each row, the second along y within each column.
    """
    cell = field.grid.cell
    height = np.where(field.valid, field.height, np.nan)
    signed = []
    for axis in (1, 0):
        rise = np.nan_to_num(np.diff(height, axis=axis))
        run = np.cumsum(np.hypot(rise, cell), axis=axis)
        run = np.insert(run, 0, 0.0, axis=axis)
        signed.append(run - np.take(run, [height.shape[axis] // 2], axis=axis))
    return signed[0], signed[1]


def line_offsets(field: HeightField, ground: Ground, width: float, spacing: float) -> Array:
    """Positions y of the scan lines [m], shape (K,): evenly spaced on the skin across the target.

    Args:
        field: The skin.
        ground: Where the brush may go.
        width: Between the outermost lines on the skin, at most [m].
        spacing: Of the lines on the skin, at most [m].
    """
    y = np.arange(field.grid.y[0], field.grid.y[-1] + STEP / 2, STEP)
    wide = ground.allowed.sum(axis=1) * field.grid.cell >= spacing
    wide[len(wide) // 2] = True
    flags = np.interp(y, field.grid.y, wide) > 0.99
    low, high = _run_around(flags, int(np.argmin(np.abs(y))))
    profile = field.points_at(np.column_stack([np.zeros_like(y), y]))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    along -= along[np.argmin(np.abs(y))]
    first, last = max(along[low], -width / 2.0), min(along[high], width / 2.0)
    count = int(np.ceil((last - first) / spacing - 1e-6)) + 1 if last - first > spacing / 3.0 else 1
    wanted = np.linspace(first, last, count) if count > 1 else np.zeros(1)
    return np.interp(wanted, along, y)


def scan_paths(ground: Ground, offsets: ArrayLike, spacing: float) -> list[ScanPath]:
    """Paths over the scan lines: first those that leave the target towards +x, then towards -x.

    Args:
        ground: Where the brush may go; the target is at (0, 0).
        offsets: Positions y of the scan lines [m], ascending, shape (K,).
        spacing: Of the lines, which sets the width of the turns [m].
    """
    offsets = np.asarray(offsets, dtype=float)
    orders = (offsets, offsets[::-1])
    return [_walk(ground, order, spacing, side) for side in (1.0, -1.0) for order in orders]


def turn(gap: float, spacing: float) -> Array:
    """A turn by 180 deg from heading +x at y = 0 to heading -x at y = `gap` > 0 [m].

    Its curvature grows and shrinks linearly with length. Returns positions [m], shape (N, 2).
    """
    if gap <= _WIDE * spacing:
        pieces = [np.pi * _ramp(200)]
        size = gap / _rise(pieces[0])
        lengths = np.linspace(0.0, size, 201)
    else:
        quarter = 0.5 * np.pi * _ramp(100)
        size = 0.5 * spacing / _rise(quarter)
        straight = gap - spacing
        pieces = [quarter, [0.5 * np.pi], 0.5 * np.pi + quarter]
        lengths = np.concatenate([np.linspace(0.0, size, 101), [size + straight / 2.0],
                                  size + straight + np.linspace(0.0, size, 101)])  # fmt: skip
    heading = np.concatenate(pieces)
    x = cumulative_trapezoid(np.cos(heading), lengths, initial=0.0)
    y = cumulative_trapezoid(np.sin(heading), lengths, initial=0.0)
    return np.column_stack([x, y * gap / y[-1]])


def _ramp(count: int) -> Array:
    """From 0 to 1 with a rate that rises and falls linearly, shape (count + 1,)."""
    u = np.linspace(0.0, 1.0, count + 1)
    return np.where(u < 0.5, 2.0 * u**2, 1.0 - 2.0 * (1.0 - u) ** 2)


def _rise(heading: Array) -> float:
    """Sideways travel of a unit length of path with the given headings [rad]."""
    return float(np.trapezoid(np.sin(heading), dx=1.0 / (len(heading) - 1)))


def _walk(ground: Ground, offsets: Array, spacing: float, side: float) -> ScanPath:
    """The path that leaves the target towards `side` of x and takes the lines in the given order."""
    x, y, lines = 0.0, 0.0, 0
    pieces = [np.zeros((1, 2))]
    for following in offsets:
        if abs(following - y) < STEP:
            continue
        end = _turn_into(ground, x, y, float(following), side, spacing)
        if end is None:
            continue
        corner, curve = end
        pieces += [_straight(x, corner, y), curve]
        x, y, side, lines = float(curve[-1, 0]), float(following), -side, lines + 1
    pieces.append(_straight(x, _line_end(ground, x, y, side), y))
    plane = np.concatenate(pieces)
    apart = np.linalg.norm(np.diff(plane, axis=0), axis=1) > 1e-6
    return ScanPath(plane[np.concatenate([[True], apart])], max(lines, 1))


def _turn_into(
    ground: Ground, x: float, y: float, following: float, side: float, spacing: float
) -> tuple[float, Array] | None:
    """Where to leave a line and the turn into the next; the farthest that fits, nothing if none does."""
    gap = following - y
    shape = turn(abs(gap), spacing) * (side, np.sign(gap))
    for corner in _positions(x, _line_end(ground, x, y, side)):
        curve = shape + np.array([corner, y])
        if ground.bears(curve).all():
            return corner, curve[1:]
    return None


def _positions(near: float, far: float) -> Iterator[float]:
    """Positions between `far` and `near` [m], the far one first."""
    count = max(int(abs(far - near) / (2.0 * STEP)), 0)
    return iter(far + (near - far) * np.arange(count + 1) / max(count, 1))


def _line_end(ground: Ground, x: float, y: float, side: float) -> float:
    """How far the line at y may be followed from x towards `side` [m]."""
    reach = np.arange(0.0, 2.0 * ground.grid.half_length, STEP)
    bears = ground.bears(np.column_stack([x + side * reach, np.full_like(reach, y)]))
    _, last = _run_around(bears, 0)
    return x + side * float(reach[last])


def _straight(start: float, end: float, y: float) -> Array:
    """Positions on the line at y from `start` (left out) to `end` [m], shape (N, 2)."""
    count = max(int(np.ceil(abs(end - start) / STEP)), 1)
    x = np.linspace(start, end, count + 1)[1:]
    return np.column_stack([x, np.full_like(x, y)])


def _run_around(flags: Mask, middle: int) -> tuple[int, int]:
    """First and last index of the run of true flags that holds `middle`."""
    step: Callable[[Mask], int] = lambda part: int(np.argmin(part)) if not part.all() else len(part)  # noqa: E731
    after = max(step(flags[middle:]) - 1, 0)
    before = max(step(flags[middle::-1]) - 1, 0)
    return middle - before, middle + after
