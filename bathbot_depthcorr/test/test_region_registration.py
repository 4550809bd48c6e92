import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.registration import Region, RegionError, Registration, region_camera
from bathbot_depthcorr.geometry.rigid import inverse, transform_from
from bathbot_depthcorr.live.live_region import LiveRegion
from depthcorr_wall import colour_camera, depth_camera, wall
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

DEPTH, COLOUR = depth_camera(424, 240), colour_camera(640, 360)
T_COLOUR_DEPTH = transform_from(
    Rotation.from_rotvec((0.004, -0.006, 0.003)).as_matrix(), (-0.059, 0.0003, 0.0002)
)
REGION = Region(270, 130, 100, 90)


def seen_by_depth(plane_colour: Plane, camera: Pinhole = DEPTH) -> np.ndarray:
    """Depth of a plane of the colour frame in the depth camera [m], shape (H, W)."""
    plane = plane_colour.transformed(inverse(T_COLOUR_DEPTH))
    return plane.depth_along(camera.directions(camera.pixel_grid())).astype(np.float32)


def seen_by_colour(plane_colour: Plane, camera: Pinhole) -> np.ndarray:
    return plane_colour.depth_along(camera.directions(camera.pixel_grid()))


@settings(max_examples=40, deadline=None)
@given(
    distance=st.floats(0.5, 3.0),
    tilts=st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)),
    corner=st.tuples(st.integers(60, 420), st.integers(30, 230)),
)
def test_a_plane_comes_back_as_that_plane_without_a_hole(distance, tilts, corner):
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, Region(*corner, 100, 90), 0.1, 20.0)
    plane = wall(distance, *tilts)
    depth, truth = seen_by_depth(plane), seen_by_colour(plane, registration.camera)
    margin = 12  # colour pixels that the narrower depth image does not see
    inside = DEPTH.project(
        (registration.camera.deproject(registration.camera.pixel_grid(), truth) - T_COLOUR_DEPTH[:3, 3])
        @ T_COLOUR_DEPTH[:3, :3]
    )
    seen = ((inside > margin) & (inside < np.array([DEPTH.width, DEPTH.height]) - margin)).all(axis=-1)
    rays = registration.camera.directions(registration.camera.pixel_grid())
    slanted = np.abs(rays @ plane.normal) < 0.25 * np.linalg.norm(rays, axis=-1)  # seen at 75 degrees or more
    seen &= ~slanted & (truth < 10.0)
    patch = registration.apply(depth)
    assert patch.shape == (90, 100)
    assert np.isfinite(patch[seen]).all()
    found = np.isfinite(patch) & ~slanted
    assert_allclose(patch[found], truth[found], atol=0.5e-3)


def test_the_same_camera_at_the_same_place_gives_the_same_patch():
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.7, 0.71, (DEPTH.height, DEPTH.width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.1] = np.nan
    region = Region(50, 40, 80, 60)
    patch = Registration(DEPTH, DEPTH, np.eye(4), region).apply(depth)
    expected = depth[40:100, 50:130]
    assert_array_equal(np.isnan(patch), np.isnan(expected))
    # Pixels overlap by a tenth, and the nearest wins: never farther, never off by more than the slope allows.
    assert_allclose(patch, expected, atol=2e-3)


def scene_with_a_bar():
    """A bar at 0.6 m before a wall at 1.2 m; the truth in the region by ray casting."""
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION)
    near, far = wall(0.6), wall(1.2)
    rays = DEPTH.directions(DEPTH.pixel_grid())
    depth_near, depth_far = seen_by_depth(near), seen_by_depth(far)
    across = ((rays * depth_near[..., None]) @ T_COLOUR_DEPTH[:3, :3].T + T_COLOUR_DEPTH[:3, 3])[..., 0]
    depth = np.where(np.abs(across) < 0.02, depth_near, depth_far)
    colour_rays = registration.camera.directions(registration.camera.pixel_grid())
    on_bar = np.abs(colour_rays[..., 0] * 0.6) < 0.02
    return registration, depth.astype(np.float32), on_bar


def test_the_foreground_wins_and_edges_move_by_a_pixel_at_most():
    registration, depth, on_bar = scene_with_a_bar()
    patch = registration.apply(depth)
    columns = np.flatnonzero(on_bar.all(axis=0))
    first, last = columns[0], columns[-1]
    assert_allclose(patch[:, first + 1 : last], 0.6, atol=0.5e-3)
    others = patch[:, np.r_[: first - 1, last + 2 : 100]]
    assert_allclose(others[np.isfinite(others)], 1.2, atol=0.5e-3)


def test_nothing_is_drawn_between_two_surfaces_and_what_is_hidden_is_none():
    registration, depth, _ = scene_with_a_bar()
    patch = registration.apply(depth)
    found = patch[np.isfinite(patch)]
    assert ((np.abs(found - 0.6) < 1e-3) | (np.abs(found - 1.2) < 1e-3)).all()
    assert np.isnan(patch).any()  # the wall beside the bar that only the colour camera sees


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 999), share=st.floats(0.3, 1.0))
def test_depth_is_never_invented(seed, share):
    """Every registered depth comes from a depth pixel that projects within a pixel or two of it."""
    rng = np.random.default_rng(seed)
    depth = seen_by_depth(wall(0.8))
    depth[rng.random(depth.shape) < share] = np.nan
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION)
    points = DEPTH.deproject(DEPTH.pixel_grid(), depth) @ T_COLOUR_DEPTH[:3, :3].T + T_COLOUR_DEPTH[:3, 3]
    pixels = registration.camera.project(points[np.isfinite(depth)])
    patch = registration.apply(depth)
    found = np.argwhere(np.isfinite(patch))[:, ::-1][:50]
    for pixel in found:
        assert np.abs(pixels - pixel).max(axis=-1).min() <= 1.5
    assert np.isnan(registration.apply(np.full_like(depth, np.nan))).all()


def test_only_the_part_that_may_show_is_touched():
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, Region(400, 30, 40, 40))
    depth = np.full((DEPTH.height, DEPTH.width), np.nan, np.float32)
    depth[registration.rows, registration.columns] = 0.8
    everywhere = np.full_like(depth, 0.8)
    assert np.isfinite(registration.apply(depth)).all()
    assert_array_equal(registration.apply(depth)[3:-3, 3:-3], registration.apply(everywhere)[3:-3, 3:-3])
    assert np.isfinite(depth).mean() < 0.2


def test_depth_outside_the_range_is_left_out():
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION, nearest=0.5, farthest=1.0)
    assert np.isnan(registration.apply(seen_by_depth(wall(0.4)))).all()
    assert np.isnan(registration.apply(seen_by_depth(wall(1.3)))).all()


def test_the_regions_camera_sees_the_same_rays():
    region = region_camera(COLOUR, REGION)
    pixels = region.pixel_grid()
    assert_allclose(region.directions(pixels), COLOUR.directions(pixels + np.array([270, 130])), atol=1e-12)


@pytest.mark.parametrize("region", [(600, 0, 41, 10), (0, 300, 10, 61), (-1, 0, 10, 10)])
def test_a_region_outside_the_image_is_refused_in_one_line(region):
    with pytest.raises(RegionError, match=r"leaves the colour image of 640x360; choose") as caught:
        Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, Region(*region))
    assert "\n" not in str(caught.value)


def test_a_region_the_depth_camera_does_not_see_is_refused():
    aside = transform_from(Rotation.from_rotvec((0.0, 1.4, 0.0)).as_matrix())
    with pytest.raises(RegionError, match="depth camera sees nothing"):
        Registration(DEPTH, COLOUR, aside, REGION)


def test_depth_of_another_size_is_refused():
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION)
    with pytest.raises(RegionError, match=r"shape \(120, 212\), the region was prepared for \(240, 424\)"):
        registration.apply(np.ones((120, 212), np.float32))


def test_a_live_region_waits_until_all_is_known_and_tells_its_trouble():
    depth, live = seen_by_depth(wall(0.8)), LiveRegion(REGION, 4.0)
    live.meet_depth_camera(DEPTH)
    live.meet_transform(T_COLOUR_DEPTH)
    assert live.apply(depth) is None
    live.meet_colour_camera(COLOUR)
    view = live.apply(depth)
    assert_array_equal(view.depth, Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION).apply(depth))
    assert (view.camera.width, view.camera.height) == (100, 90)
    live.meet_colour_camera(COLOUR.scaled(320, 180))
    assert live.apply(depth) is None
    assert "leaves the colour image of 320x180" in live.trouble
    live.meet_colour_camera(COLOUR)
    assert not live.trouble


def test_noise_opens_no_cracks_and_pulls_a_wall_hardly_nearer():
    """Neighbours overlap by a tenth, where the nearer one wins: a bias of a fraction of the noise."""
    depth = seen_by_depth(wall(0.75, 0.3, 0.2))
    noise = np.random.default_rng(3).normal(0.0, 0.002, depth.shape).astype(np.float32)
    registration = Registration(DEPTH, COLOUR, T_COLOUR_DEPTH, REGION)
    patch, clean = registration.apply(depth + noise), registration.apply(depth)
    assert np.isnan(patch).mean() < 2e-3
    assert abs(np.nanmean(patch - clean)) < 0.15 * 0.002
