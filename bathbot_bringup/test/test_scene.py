"""The bathroom of a seed, and what its camera sees."""

import numpy as np
import pytest
from bathbot_bringup.sim.body import body_count
from bathbot_bringup.sim.camera.arm_mesh import ArmMesh
from bathbot_bringup.sim.camera.d455_unit import PRESETS, make_unit
from bathbot_bringup.sim.camera.scene_camera import BathroomView
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_bringup.sim.scene import FLOOR, PEDESTAL_RADIUS, T_LINK_OPTICAL, BathroomScene, true_camera_pose
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_scrub.rm65.arm.rm65 import RM65
from numpy.testing import assert_allclose
from scene_reach import head_poses, reachable_areas

HOME = RM65().home


@pytest.fixture(scope="module")
def unit():
    return make_unit(1, PRESETS["perfect"], 424, 240)


@pytest.fixture(scope="module")
def view(unit) -> BathroomView:
    return BathroomView(BathroomScene(1), load_scenario("calm"), unit)


@pytest.mark.parametrize("seed", range(12))
def test_trunk_upper_limb_and_thigh_are_seen_and_reached(seed):
    areas = reachable_areas(BathroomScene(seed))
    for region in ("trunk", "upper limb", "thigh"):
        assert areas[region].reachable > 150e-4  # [m^2]
        assert areas[region].reachable <= areas[region].visible


def test_seeds_walk_through_the_bodies_and_the_camera_stays():
    scenes = [BathroomScene(seed) for seed in range(body_count())]
    assert len({scene.body.vertices.tobytes() for scene in scenes}) == body_count()
    for scene in scenes:
        assert_allclose(scene.T_base_camera, true_camera_pose())
    assert_allclose(scenes[0].T_base_camera_link @ T_LINK_OPTICAL, scenes[0].T_base_camera, atol=1e-12)


def test_a_scene_is_the_same_again():
    first, again = BathroomScene(5), BathroomScene(5)
    assert_allclose(first.T_base_body, again.T_base_body, atol=0.0)
    assert first.look == again.look
    assert_allclose(first.dressed.albedo, again.dressed.albedo, atol=0.0)


@pytest.mark.parametrize("seed", range(12))
def test_legs_clear_the_pedestal_and_stay_above_the_floor(seed):
    scene = BathroomScene(seed)
    vertices = transform_points(scene.T_base_body, scene.body.vertices)
    low = vertices[vertices[:, 2] < 0.0]
    assert np.hypot(low[:, 0], low[:, 1]).min() > PEDESTAL_RADIUS
    assert vertices[:, 2].min() > FLOOR - 0.01


def test_a_perfect_depth_picture_is_the_surface(view, unit):
    frame, t = view.frame(1.3), 1.3
    camera = unit.depth
    T_base_camera = view.T_base_depth
    rng = np.random.default_rng(0)
    errors = []
    for u, v in rng.uniform((120, 60), (300, 200), size=(60, 2)).astype(int):
        direction = T_base_camera[:3, :3] @ camera.directions((u, v))
        point = view.surface.true_point(T_base_camera[:3, 3], direction, t)
        if np.isfinite(point).all():
            errors.append(transform_points(inverse(T_base_camera), point)[2] - frame.depth[v, u])
    assert len(errors) > 15
    assert np.median(np.abs(errors)) < 1e-4


def test_the_arm_shows_where_its_joints_say(view):
    without, with_arm = view.frame(0.0), view.frame(0.0, HOME)
    nearer = with_arm.depth < without.depth - 1e-3
    assert 0.02 < nearer.mean() < 0.5
    assert (with_arm.colour[nearer] != without.colour[nearer]).any(
        axis=-1
    ).mean() > 0.5  # the colour camera stands 59 mm aside
    assert not (with_arm.depth > without.depth + 1e-4).any()


def test_the_brush_s_tip_is_the_head_s_origin():
    tip = RM65().head(HOME)
    vertices = transform_points(inverse(tip), ArmMesh().vertices(HOME))
    brush = vertices[np.hypot(vertices[:, 0], vertices[:, 1]) < 0.026]
    assert_allclose(brush[:, 2].max(), 0.0, atol=1e-6)


def test_the_person_moves_between_frames(view):
    assert np.abs(view.frame(0.0).depth - view.frame(2.0).depth).max() > 1e-3
    assert (view.frame(2.0).colour == view.frame(2.0).colour).all()


def test_head_poses_are_rigid_and_look_into_the_skin():
    normals = np.array([(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.6, 0.0, 0.8)])
    poses = head_poses(np.zeros((3, 3)), normals)
    assert_allclose(np.linalg.det(poses[..., :3, :3]), 1.0, atol=1e-12)
    assert_allclose(poses[:, 2, :3, 2], -normals, atol=1e-12)
