import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_localize.surface.workspace import outward_normals
from hypothesis import assume, given
from hypothesis import strategies as st
from rm65_links import SHAPE

SPACE = SHAPE.workspace


def wall(distance, size=60, pitch=0.004):
    """Points of a frontal wall in the colour camera's frame, shape (size, size, 3)."""
    grid = (np.arange(size) - size // 2) * pitch
    x, y = np.meshgrid(grid, grid)
    return np.stack([x, y, np.full_like(x, distance)], axis=-1)


@given(
    radius=st.floats(0.05, 0.8),
    direction=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1),
    outward=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 0.1),
)
def test_the_wrist_decides(radius, direction, outward):
    outward = np.asarray(outward) / np.linalg.norm(outward)
    wrist = np.asarray(SPACE.shoulder) + radius * np.asarray(direction) / np.linalg.norm(direction)
    assume(min(abs(radius - SPACE.nearest), abs(radius - SPACE.farthest)) > 1e-6)
    expected = SPACE.nearest <= radius <= SPACE.farthest
    assert bool(SPACE.holds(wrist - SPACE.behind * outward, outward)) == expected


def camera_towards_x(position):
    """Pose of a camera in the base frame that looks along x."""
    return transform_from([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], position)


@pytest.mark.parametrize(("wall_x", "expected"), [(0.60, True), (0.90, False)], ids=["in reach", "too far"])
def test_a_wall_across_x(wall_x, expected):
    T_base_camera = camera_towards_x((-0.1, 0.0, 0.2405))
    points = wall(wall_x + 0.1)
    mask = SPACE.workable(points, outward_normals(points), T_base_camera, 9)
    assert mask[30, 30] == expected


def test_unknown_cells_are_not_workable():
    points = wall(0.7)
    points[:20] = np.nan
    mask = SPACE.workable(points, outward_normals(points), camera_towards_x((-0.1, 0.0, 0.2405)), 9)
    assert not mask[:20].any()
    assert mask[30:].any()
