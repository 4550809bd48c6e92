"""Which scan path washes most: both directions of scanning, both sides, both orders of the lines."""

from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.clearance import Column, clear
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from bathbot_scrub.errors import SurfaceError
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import Mask
from bathbot_scrub.path.scan_lines import Ground, ScanPath, line_offsets, scan_paths, skin_distance
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

Array = NDArray[np.float64]
_ACROSS = 0.9  # worth of a path across the target's direction of travel: the head must turn first
_AGAINST = 0.95  # worth of one that starts against it


class Patch(NamedTuple):
    """The skin to wash and where the middle of the brush may go for it.

    Attributes:
        skin: Cells to wash, shape (rows, columns).
        ground: Cells for the middle of the brush.
    """

    skin: Mask
    ground: Ground


class Candidate(NamedTuple):
    """A path over a patch and its worth: the number of cells it washes, less for awkward starts."""

    path: ScanPath
    worth: float


def choose_patch(field: HeightField, seen: Array, settings: ScrubPlannerSettings) -> Patch:
    """The patch around the target: on skin, off its edges, not too steep, with room for the head.

    Args:
        field: The skin.
        seen: All that was seen, skin or not, in the patch frame [m], shape (..., 3), NaN where nothing was.
        settings: Of the planner.

    Raises:
        SurfaceError: When the target itself does not lie on smooth skin with room over it.
    """
    with np.errstate(invalid="ignore"):
        flat = field.normals[..., 2] >= np.cos(np.radians(settings.max_slope_deg))
    skin = around_target(field.valid & flat)
    middle = skin.shape[0] // 2, skin.shape[1] // 2
    if not skin[middle]:
        raise SurfaceError("no smooth skin at the contact target itself; ask for a newer target")
    edge = ndimage.distance_transform_edt(np.pad(skin, 1))[1:-1, 1:-1] * settings.cell
    # at the edge of a hand the target itself may be nearer to it than the margin
    off_edge = edge >= min(settings.edge_margin, 0.6 * edge[middle])
    along, across = (np.abs(length) for length in skin_distance(field))
    inside = (along <= settings.patch_length / 2.0) & (across <= settings.patch_width / 2.0)
    # the lines keep half a brush from the border, their turns may come nearer
    margin = settings.edge_margin - settings.cell / 2.0
    ground = (along <= settings.patch_length / 2.0 - margin) & (across <= settings.patch_width / 2.0 - margin)
    ground &= off_edge & inside
    free = _with_room(field, seen, ground, settings)
    if ground[middle] and not free[middle]:
        raise SurfaceError(
            f"within {settings.head_room * 1e3:.0f} mm of the contact target something stands higher than "
            f"{settings.max_relief * 1e3:.0f} mm; ask for a target with room for the brush"
        )
    return Patch(skin & inside, Ground(field.grid, around_target(free)))


def _with_room(field: HeightField, seen: Array, ground: Mask, settings: ScrubPlannerSettings) -> Mask:
    """Cells of the ground over which the head has room, shape (rows, columns)."""
    rows, columns = np.nonzero(ground)
    plane = np.column_stack([field.grid.x[columns], field.grid.y[rows]])
    column = Column(settings.head_room, settings.max_relief)
    free = np.zeros_like(ground)
    free[rows, columns] = clear(seen, field.points_at(plane), field.normals_at(plane), column)
    return free


def candidates(field: HeightField, patch: Patch, settings: ScrubPlannerSettings) -> list[Candidate]:
    """Paths over a patch, the best first."""
    found = []
    extents = (settings.patch_length, settings.patch_width)
    for turned, width in ((False, extents[1]), (True, extents[0])):
        view = field.transposed() if turned else field
        ground = Ground(view.grid, patch.ground.allowed.T if turned else patch.ground.allowed)
        spacing = settings.line_spacing * settings.brush_diameter
        offsets = line_offsets(view, ground, width - settings.brush_diameter, spacing)
        spacing = float(np.diff(offsets).mean()) if len(offsets) > 1 else spacing
        for index, path in enumerate(scan_paths(ground, offsets, spacing)):
            path = path._replace(plane=path.plane[:, ::-1]) if turned else path
            worth = washed(path.plane, patch, settings.brush_diameter / 2.0).sum()
            worth *= (_ACROSS if turned else 1.0) * (_AGAINST if index >= 2 else 1.0)
            found.append(Candidate(path, float(worth)))
    return sorted(found, key=lambda candidate: -candidate.worth)


def washed(plane: ArrayLike, patch: Patch, radius: float) -> Mask:
    """Cells of a patch within `radius` [m] of positions (x, y) [m], shape (N, 2) -> (rows, columns)."""
    row, column, _ = patch.ground.grid.cells_of(plane)
    far = np.ones(patch.skin.shape, dtype=bool)
    far[row, column] = False
    return patch.skin & (ndimage.distance_transform_edt(far) * patch.ground.grid.cell <= radius)


def around_target(mask: Mask) -> Mask:
    """The connected part of a mask that holds the middle cell, shape (rows, columns); may be empty."""
    labels, _ = ndimage.label(mask)
    middle = labels[mask.shape[0] // 2, mask.shape[1] // 2]
    return (labels == middle) & mask if middle else np.zeros_like(mask)
