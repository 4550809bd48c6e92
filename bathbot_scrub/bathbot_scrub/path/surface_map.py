"""The skin while it is being scrubbed: what was seen before the arm came, moved with what is seen now.

The arm hides the very skin it scrubs. So the map starts from the last surface without the arm; each
new surface (NaN where the arm hides it) renews the cells in sight, and the median of their motion
along the normal moves the hidden ones too: breathing, sway, a sudden shift. How high the skin stands
over a breath or two is told by its level.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from bathbot_scrub.errors import TargetLostError
from bathbot_scrub.path.height_field import HeightField, smooth
from bathbot_scrub.path.patch import Cells, Mask, PatchGrid, around, connected_skin
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

Array = NDArray[np.float64]
_GATE = 0.05  # farther from the map a point is no skin of this patch [m]
_AGREES = 0.006  # a cell this near the moved map is fused into it [m]
_MEMORY = 3.0  # of how many pictures a cell keeps the mean
_RELIEF = 0.15  # height of the skin over the tangent plane at the edge of the map [m]
_NEAREST = 0.015  # between target and its nearest pixel [m]
_JUMP = 0.0015  # beyond all heights of the last breaths [m]; a breath takes longer between two pictures
_KNOWN = 0.5  # share of the window from which the mean counts


class Sighting(NamedTuple):
    """A surface not decoded yet: `decode` gives points in the base frame, shape (H, W, 3); `stamp` [s]."""

    stamp: float
    decode: Callable[[], Array]


class Sight(NamedTuple):
    """What one surface told about the motion of the skin.

    Attributes:
        cells: Number of cells of skin in sight.
        step: Motion along the outward normal since the surface before [m]; 0 when too few cells.
    """

    cells: int
    step: float


class SurfaceMap:
    """Heights of the skin over a patch grid, kept up to date."""

    def __init__(self, grid: PatchGrid, surface: Array, stamp: float, settings: ScrubPlannerSettings) -> None:
        """Start from the surface seen before the arm came.

        Args:
            grid: Where the map lies.
            surface: Organised points in the base frame [m], shape (H, W, 3), NaN where unknown.
            stamp: Time of the surface [s].
            settings: Of the planner.

        Raises:
            SurfaceError: When no skin is seen at the target.
        """
        self.grid, self._settings = grid, settings
        points = grid.to_patch(surface)
        reach = max(grid.half_length, grid.half_width) + 2.0 * grid.cell
        points = around(points, reach, _RELIEF).crop(points)
        skin = connected_skin(points, settings.depth_jump, _NEAREST)
        self.shift = 0.0
        self.stamp = self.moved = stamp
        self._levels = SkinLevel(settings.breath_window, settings.breath_range)
        self._levels.add(stamp, 0.0)
        self._height, self._count = grid.bin(points[skin])
        self._slope = self.field().slope  # known now, it carries heights to the middle of their cells
        self._height, self._count = grid.bin(points[skin], self._slope)
        self._weight = np.minimum(self._count, 1.0)

    @property
    def level(self) -> float:
        """Shift to plan on [m]; see `SkinLevel`."""
        return self._levels.level

    @property
    def skin(self) -> Mask:
        """Cells that are skin, pinholes closed, shape (rows, columns)."""
        return ndimage.binary_closing(np.pad(self._count > 0.0, 1), np.ones((3, 3)))[1:-1, 1:-1]

    def see(self, surface: Array, stamp: float) -> Sight:
        """Take in a newer surface in the base frame [m], shape (H, W, 3), of time `stamp` [s].

        Raises:
            TargetLostError: When the skin has moved too far since the map was started.
        """
        seen = self._bin_near(surface)
        known = np.isfinite(self._height)
        both = (seen.count > 0.0) & known
        self.stamp = max(self.stamp, stamp)
        if both.sum() < self._settings.min_cells:
            return Sight(int(both.sum()), 0.0)
        step = float(np.median((seen.height - self._height)[both]))
        self.shift += step
        self.moved = max(self.moved, self.stamp)
        self._levels.add(stamp, self.shift)
        self._height = self._height + step
        self._fuse(seen, both)
        if abs(self.shift) > self._settings.max_shift:
            raise TargetLostError(
                f"the skin moved {self.shift * 1000.0:+.0f} mm along its normal, allowed are "
                f"{self._settings.max_shift * 1000.0:.0f} mm; retract and ask for a new contact target"
            )
        return Sight(int(both.sum()), step)

    def recall(self, surface: Array, stamp: float) -> None:
        """Take in how high the skin stood in another surface, without renewing any cell from it."""
        seen = self._bin_near(surface)
        both = (seen.count > 0.0) & np.isfinite(self._height)
        if both.sum() >= self._settings.min_cells:
            offset = float(np.median((seen.height - self._height)[both]))
            self._levels.add(stamp, self.shift + offset)
            self.moved = max(self.moved, stamp)

    def watch_from(self, now: float) -> None:
        """Begin to insist on seeing skin at time `now` [s]: the approach before it hid what it would."""
        self.moved = max(self.moved, now)

    def demand_in_sight(self, now: float) -> None:
        """Raise TargetLostError when the motion of the skin was last told too long before `now` [s]."""
        if now - self.moved > self._settings.lost_after:
            raise TargetLostError(
                f"no skin around the arm was seen for {now - self.moved:.1f} s, allowed are "
                f"{self._settings.lost_after} s; is the camera's view free and target_localizer active?"
            )

    def field(self) -> HeightField:
        """The smooth surface to plan on."""
        cells = Cells(self._height + (self.level - self.shift), np.minimum(self._count, 4.0))
        return HeightField(self.grid, smooth(cells, self._settings.smoothing / self.grid.cell), self.skin)

    def _bin_near(self, surface: Array) -> Cells:
        """Cells of the points that can be skin of the map."""
        points = self.grid.to_patch(surface[np.isfinite(surface[..., 2])])
        row, column, inside = self.grid.cells_of(points[:, :2])
        near = inside & (np.abs(points[:, 2] - self._height[row, column]) < _GATE)
        return self.grid.bin(points[near], self._slope)

    def _fuse(self, seen: Cells, both: Mask) -> None:
        """Average cells in sight into the moved map where they agree with it."""
        with np.errstate(invalid="ignore"):
            fresh = both & (np.abs(seen.height - self._height) < _AGREES)
        weight = self._weight[fresh]
        self._height[fresh] = (weight * self._height[fresh] + seen.height[fresh]) / (weight + 1.0)
        self._weight[fresh] = np.minimum(weight + 1.0, _MEMORY)
        self._count[fresh] = np.maximum(self._count[fresh], seen.count[fresh])


class SkinLevel:
    """The height of breathing skin to plan on, along the normal.

    A segment is followed seconds after it was planned, about half a breath: planned on the newest height it
    could be off by twice the breath's amplitude. So plans stand on the mean of the last breaths as soon as
    they are known. A height that leaves what the last breaths have shown, at once or little by little, is a
    move of the body: it is followed, and the breaths before it are forgotten.
    """

    def __init__(self, window: float, spread: float) -> None:
        """Begin without any height.

        Args:
            window: Time over which is averaged: a breath or two [s].
            spread: Of the newest height from the mean, beyond which the body has moved [m].
        """
        self._window, self._spread = window, spread
        self._times: list[float] = []
        self._heights: list[float] = []

    def add(self, time: float, height: float) -> None:
        """Take in a height [m] at a time [s]; one older than the newest only fills the past."""
        if self._times and time < self._times[-1]:
            index = int(np.searchsorted(self._times, time))
            self._times.insert(index, time)
            self._heights.insert(index, height)
            return
        if self._heights and not self._familiar(height):
            self._times, self._heights = [], []
        self._times.append(time)
        self._heights.append(height)
        while self._times[0] < time - self._window:
            del self._times[0], self._heights[0]

    @property
    def level(self) -> float:
        """The height to plan on [m]: the mean where enough of a breath is known, else the newest."""
        newest, known = self._heights[-1], self._times[-1] - self._times[0] >= _KNOWN * self._window
        mean = float(np.mean(self._heights))
        return mean if known and abs(newest - mean) <= self._spread else newest

    def _familiar(self, height: float) -> bool:
        return min(self._heights) - _JUMP <= height <= max(self._heights) + _JUMP
