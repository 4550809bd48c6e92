"""One pair of pictures to targets and surface: right, equivariant, and clear about what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import rotate, transform_from, transform_points
from bathbot_depthcorr.ros.verdict import Level, Verdict
from bathbot_localize.errors import LocalizeError, SettingsError
from bathbot_localize.regions import SkinRegion
from bathbot_localize.surface.disc import NoSkinError
from bathbot_localize.target.localizer import RoughSurfaceError, locate, locate_all, make_frame, surface_of
from bathbot_localize.target.localizer_session import LocalizerSession, UnknownRegionError
from bathbot_localize.target.target import localization_error
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import (
    COLOUR,
    DEPTH,
    T_BASE_COLOUR,
    T_COLOUR_DEPTH,
    box_around,
    hit,
    pixel_of,
    plane,
    render,
    rod,
    sphere,
    with_noise,
)  # fmt: skip
from rm65_links import SHAPE, links_of
from scipy.spatial.transform import Rotation

SETTINGS = TargetLocalizerSettings(disc_radius_px=12.0)
BELLY, WALL = sphere((0.55, 0.0, 0.25), 0.15), plane((1.3, 0.0, 0.0), (-1.0, 0.0, 0.0))
CENTRE = pixel_of((0.42, 0.05, 0.30))
TRUNK = SkinRegion("Trunk_skin", 0.9, box_around(CENTRE, 40.0))
CLEAN = render(BELLY, WALL)


def frame_of(depth, links=None, T_base_colour=T_BASE_COLOUR, shape=SHAPE):
    return make_frame(depth, DEPTH, COLOUR, T_COLOUR_DEPTH, T_base_colour, shape, links or {})


def test_the_target_is_on_the_ray_of_the_box_centre_and_on_the_skin():
    target = locate(frame_of(CLEAN), TRUNK, SETTINGS)
    assert target.pixel == pytest.approx(tuple(CENTRE))
    assert localization_error(hit(BELLY, target.pixel), target.T_base_target[:3, 3]) < 0.0003
    outward = (target.T_base_target[:3, 3] - (0.55, 0.0, 0.25)) / 0.15
    assert -target.T_base_target[:3, 2] @ outward > np.cos(np.radians(1.0))


def test_noise_of_a_camera_moves_the_target_by_less_than_a_millimetre():
    rng = np.random.default_rng(0)
    errors = [
        localization_error(hit(BELLY, target.pixel), target.T_base_target[:3, 3])
        for target in (
            locate(frame_of(with_noise(CLEAN, rng, 0.07, 0.01)), TRUNK, SETTINGS) for _ in range(30)
        )
    ]
    assert np.mean(errors) < 0.0004
    assert np.max(errors) < 0.001


@settings(max_examples=15, deadline=None)
@given(turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3), shift=st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_a_rigid_motion_of_the_scene_moves_the_target_with_it(turn, shift):
    """Camera and person moved together: the same picture, so position and normal move rigidly."""
    move = transform_from(Rotation.from_rotvec(turn).as_matrix(), shift)
    anywhere = replace(
        SHAPE, workspace=replace(SHAPE.workspace, nearest=0.0, farthest=np.inf)
    )  # the arm does not move with them
    here = locate(frame_of(CLEAN, shape=anywhere), TRUNK, SETTINGS).T_base_target
    moved = frame_of(CLEAN, T_base_colour=move @ T_BASE_COLOUR, shape=anywhere)
    there = locate(moved, TRUNK, SETTINGS).T_base_target
    np.testing.assert_allclose(there[:3, 3], transform_points(move, here[:3, 3]), atol=1e-9)
    np.testing.assert_allclose(there[:3, 2], rotate(move, here[:3, 2]), atol=1e-9)
    assert np.linalg.det(there[:3, :3]) == pytest.approx(1.0)


@settings(max_examples=10, deadline=None)
@given(y=st.floats(-0.05, 0.05), z=st.floats(0.2, 0.3))
def test_a_body_that_moves_takes_its_target_along(y, z):
    body = sphere((0.55, y, z), 0.15)
    region = TRUNK._replace(box=box_around(pixel_of((0.42, 0.05 + y, 0.05 + z)), 30.0))
    target = locate(frame_of(render(body, WALL)), region, SETTINGS)
    assert localization_error(hit(body, target.pixel), target.T_base_target[:3, 3]) < 0.0005


def test_the_arm_before_the_skin_is_not_skin():
    """An upper arm of the robot drawn into the depth picture: masked, and the target stays on the skin."""
    links = {"Link2": transform_from(translation=(0.05, 0.12, 0.42))}
    depth = render(rod((0.05, 0.12, 0.42), (0.306, 0.12, 0.42), 0.050), BELLY, WALL)
    covered = make_frame(depth, DEPTH, COLOUR, T_COLOUR_DEPTH, T_BASE_COLOUR, SHAPE, links).silhouette
    left, top, right, bottom = (int(edge) for edge in TRUNK.box)
    assert 0.1 < covered[top:bottom, left:right].mean() < 0.9
    with_arm = locate(frame_of(depth), TRUNK, SETTINGS)
    assert abs(np.linalg.norm(with_arm.T_base_target[:3, 3] - (0.55, 0.0, 0.25)) - 0.15) > 0.01
    target = locate(frame_of(depth, links), TRUNK, SETTINGS)
    on_belly = abs(np.linalg.norm(target.T_base_target[:3, 3] - (0.55, 0.0, 0.25)) - 0.15)
    assert on_belly < 0.001
    surface = surface_of(frame_of(depth, links), TRUNK.box, SETTINGS)
    offset = np.linalg.norm(surface - (0.55, 0.0, 0.25), axis=-1) - 0.15
    assert np.nanmax(np.abs(offset)) < 0.005
    assert np.isnan(surface).any()


def test_one_target_per_name_the_one_nearest_to_the_arm():
    near, far = sphere((0.45, 0.12, 0.25), 0.06), sphere((0.75, -0.12, 0.25), 0.06)
    depth = render(near, far, WALL)
    regions = [
        SkinRegion("Upperlimb_skin", 0.9, box_around(pixel_of((0.75, -0.10, 0.30)), 15.0)),
        SkinRegion("Upperlimb_skin", 0.8, box_around(pixel_of((0.44, 0.14, 0.30)), 15.0)),
        SkinRegion("Upperlimb_skin", 0.35, box_around((30.0, 30.0), 10.0)),
    ]
    looked = locate_all(frame_of(depth), regions, SETTINGS)
    assert [target.region for target in looked.targets] == ["Upperlimb_skin"]
    assert np.linalg.norm(looked.targets[0].T_base_target[:3, 3] - (0.45, 0.12, 0.25)) == pytest.approx(
        0.06, abs=0.002
    )
    assert looked.refused == {}


@pytest.mark.parametrize("depth", [np.full_like(CLEAN, np.nan), np.zeros_like(CLEAN)], ids=["nan", "zero"])
def test_no_depth_is_no_target_and_no_surface(depth):
    with pytest.raises(NoSkinError, match="no depth"):
        locate(frame_of(depth), TRUNK, SETTINGS)
    with pytest.raises(NoSkinError, match="no depth"):
        surface_of(frame_of(depth), TRUNK.box, SETTINGS)
    looked = locate_all(frame_of(depth), [TRUNK], SETTINGS)
    assert looked.targets == []
    assert "no depth" in looked.refused["Trunk_skin"]


def test_a_box_outside_the_picture_is_refused_by_name():
    looked = locate_all(frame_of(CLEAN), [TRUNK._replace(box=(900.0, 0.0, 990.0, 50.0))], SETTINGS)
    assert "outside" in looked.refused["Trunk_skin"]


def test_a_heap_of_noise_is_no_surface():
    noise = np.random.default_rng(0).uniform(0.6, 0.64, CLEAN.shape).astype(np.float32)
    with pytest.raises(RoughSurfaceError, match=r"scatter|known to"):
        locate(frame_of(noise), TRUNK, SETTINGS)


def test_the_surface_is_on_the_skin_and_smoother_than_the_pixels():
    noisy = frame_of(with_noise(CLEAN, np.random.default_rng(0)))

    def scatter(window):
        points = surface_of(noisy, TRUNK.box, TargetLocalizerSettings(surface_window=window))
        return np.nanstd(np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1)), points

    plain, _ = scatter(1)
    smooth, points = scatter(3)
    assert smooth < 0.6 * plain
    assert abs(np.nanmean(np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1)) - 0.15) < 0.0005
    assert points.shape[2] == 3


def test_averaging_does_not_bend_a_sloping_plane_beside_holes():
    slope = plane((0.5, 0.0, 0.25), (-1.0, 0.8, 0.4))
    depth = render(slope)
    depth[np.random.default_rng(0).random(depth.shape) < 0.05] = np.nan
    normal = np.array([-1.0, 0.8, 0.4]) / np.linalg.norm([-1.0, 0.8, 0.4])
    points = surface_of(frame_of(depth), TRUNK.box, TargetLocalizerSettings(surface_window=5))
    assert np.nanmax(np.abs((points - (0.5, 0.0, 0.25)) @ normal)) < 1e-5


def session_ready():
    session = LocalizerSession(SETTINGS, T_BASE_COLOUR, SHAPE)
    session.colour_camera, session.depth_camera, session.T_colour_depth = COLOUR, DEPTH, T_COLOUR_DEPTH
    return session


def test_a_session_tells_what_it_waits_for():
    session = LocalizerSession(SETTINGS, T_BASE_COLOUR, SHAPE)
    assert len(session.missing()) == 3
    assert "waiting for colour camera_info" in session.verdict(0.0).message
    with pytest.raises(LocalizeError, match="waiting for"):
        session.locate(CLEAN, 0.0, [TRUNK])


def test_a_session_names_the_first_thing_that_is_wrong():
    session = session_ready()
    assert "no corrected depth yet" in session.verdict(10.0).message
    session.seen(10.0, depth=True)
    assert "no skin regions yet" in session.verdict(10.1).message
    session.seen(10.0, regions=True)
    session.locate(CLEAN, 10.0, [])
    assert "region Trunk_skin is not found; found are none" in session.verdict(10.1).message
    session.locate(CLEAN, 10.1, [TRUNK])
    assert session.verdict(10.2).level is Level.WARN
    assert "no static transforms of the camera" in session.verdict(10.2).message
    session.placed = True
    assert session.verdict(10.2).level is Level.OK
    assert "arm is not masked" in session.verdict(10.2).message
    assert "no corrected depth for 5.0 s" in session.verdict(15.0).message


def test_an_arm_that_went_silent_stops_the_localiser():
    session = session_ready()
    session.locate(CLEAN, 10.0, [TRUNK])
    links = links_of(np.radians([0.0, 60.0, -130.0, 0.0, -80.0, 0.0]))
    for link, pose in links.items():
        if link != "base_link":
            session.add_transform("base_link", link, pose, 10.0)
    assert len(session.locate(CLEAN, 10.05, [TRUNK]).targets) == 1
    with pytest.raises(LocalizeError, match="arm cannot be masked"):
        session.locate(CLEAN, 12.0, [TRUNK])


def test_problems_are_told_until_they_are_solved():
    session = session_ready()
    session.placed = True
    session.seen(10.0, depth=True, regions=True)
    session.locate(CLEAN, 10.0, [TRUNK])
    session.fail("surface", LocalizeError("no depth"))
    session.fail("body_cloud", OSError("boom"))
    assert session.verdict(10.1) == Verdict(Level.ERROR, "surface: no depth; body_cloud: OSError: boom")
    session.solve("surface")
    session.solve("never failed")
    assert session.verdict(10.1).message == "body_cloud: OSError: boom"
    session.solve("body_cloud")
    assert session.verdict(10.1).level is Level.OK


def test_the_camera_is_placed_once_and_when_its_transforms_have_come():
    session = session_ready()
    assert session.place() is None
    assert not session.placed
    session.add_transform("camera_link", "camera_color_optical_frame", np.eye(4), None)
    assert session.place() == pytest.approx(T_BASE_COLOUR)
    assert session.placed
    assert session.place() is None


def test_choosing_a_region_starts_anew_and_checks_the_name():
    session = session_ready()
    session.locate(CLEAN, 0.0, [TRUNK])
    assert session.roi == TRUNK
    session.select("Hand_skin")
    assert session.roi is None
    with pytest.raises(NoSkinError, match="Hand_skin is not found"):
        session.surface(CLEAN, 0.1)
    with pytest.raises(UnknownRegionError, match="'Tail' is none of"):
        session.select("Tail")


@pytest.mark.parametrize(
    "bad",
    [
        {"disc_radius_px": 0.0}, {"surface_stride": 0}, {"surface_window": 4}, {"min_score": 1.5},
        {"region": "Tail"},
        {"arm_margin": -0.1}, {"max_stamp_difference": float("nan")}, {"smoothing_frames": 0},
    ],
)  # fmt: skip
def test_settings_that_cannot_be_meant_are_refused(bad):
    with pytest.raises(SettingsError, match=next(iter(bad))):
        TargetLocalizerSettings(**bad)
