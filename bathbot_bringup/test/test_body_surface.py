"""The moving skin: rays on a scene built once agree with a mesh that is really moved."""

import time

import numpy as np
import pytest
from bathbot_bringup.sim.body import vertex_normals
from bathbot_bringup.sim.body_surface import BodySurface
from bathbot_bringup.sim.render.light import ray_scene
from bathbot_bringup.sim.scenario import BodyMotion, Scenario, Shift, load_scenario
from bathbot_bringup.sim.scene import BathroomScene
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

LIVELY = Scenario(
    breath_amplitude=0.004, breath_rate=0.3, sway_amplitude=0.003,
    shifts=(Shift(time=1.0, duration=1.0, offset=(0.01, 0.02, 0.0), turn_deg=4.0, lean_deg=2.0),),
)  # fmt: skip


@pytest.fixture(scope="module")
def surface() -> BodySurface:
    return BathroomScene(1).surface(LIVELY)


def rays_at_the_body(surface: BodySurface, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays that start 6 cm before the skin and go roughly into it."""
    rng = np.random.default_rng(seed)
    vertices = surface.vertices(0.0)
    normals = vertex_normals(vertices, surface.faces)
    chosen = rng.choice(np.flatnonzero(normals[:, 0] < -0.5), count)
    directions = -normals[chosen] + rng.normal(0.0, 0.2, (count, 3))
    return vertices[chosen] + 0.06 * normals[chosen], directions / np.linalg.norm(
        directions, axis=1, keepdims=True
    )


@settings(max_examples=20, deadline=None)
@given(t=st.floats(0.0, 100.0), seed=st.integers(0, 1000))
def test_distance_agrees_with_a_moved_mesh(surface, t, seed):
    origins, directions = rays_at_the_body(surface, 40, seed)
    distances, _, _ = surface.distance(origins, directions, t)
    rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
    moved = ray_scene(surface.vertices(t), surface.faces).cast_rays(rays)["t_hit"].numpy()
    both = np.isfinite(distances) & np.isfinite(moved)
    assert (
        np.isfinite(distances) == np.isfinite(moved)
    ).mean() > 0.9  # a grazing ray may meet either side of a fold
    assert both.mean() > 0.4  # enough rays to compare
    assert np.quantile(np.abs(distances[both] - moved[both]), 0.95) < 1e-5


def test_normals_are_unit_and_face_a_camera_s_rays(surface):
    eye = BathroomScene(1).T_base_camera[:3, 3]
    targets = surface.vertices(0.7)[::100]
    directions = (targets - eye) / np.linalg.norm(targets - eye, axis=1, keepdims=True)
    distances, normals, _ = surface.distance(np.tile(eye, (len(targets), 1)), directions, 0.7)
    met = np.isfinite(distances)
    assert met.sum() > 100
    assert_allclose(np.linalg.norm(normals[met], axis=1), 1.0, atol=1e-5)
    assert ((normals * directions).sum(axis=1)[met] < 0.0).mean() > 0.98  # eyelids and the mouth overlap


def test_a_ray_into_the_air_meets_nothing(surface):
    distances, normals, part = surface.distance(np.zeros((2, 3)), np.tile([-1.0, 0.0, 0.0], (2, 1)), 0.0)
    assert np.isinf(distances).all()
    assert not normals.any()
    assert part == ""


def test_the_part_under_the_first_ray_is_named():
    scene = BathroomScene(1)
    surface = scene.surface(load_scenario("still"))
    vertices = surface.vertices(0.0)
    hand = vertices[np.argmin(np.linalg.norm(scene.body.vertices - scene.body.landmarks["wrist.L"], axis=1))]
    chest = scene.T_base_body @ np.append(scene.body.landmarks["spine02"], 1.0)
    eye = scene.T_base_camera[:3, 3]
    for target, names in ((chest[:3], ("Trunk_skin",)), (hand, ("Hand_skin", "Upperlimb_skin"))):
        direction = (target - eye) / np.linalg.norm(target - eye)
        assert surface.distance(eye[None], direction[None], 0.0)[2] in names


def test_true_point_lies_on_the_ray_and_is_the_same_again(surface):
    origins, directions = rays_at_the_body(surface, 1, 5)
    point = surface.true_point(origins[0], 3.0 * directions[0], 2.0)
    assert_allclose(np.cross(point - origins[0], directions[0]), 0.0, atol=1e-9)
    assert_allclose(surface.true_point(origins[0], directions[0], 2.0), point, atol=1e-12)
    assert np.isnan(surface.true_point((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), 2.0)).all()


def test_motion_depends_on_seed_and_time_alone():
    first, again = (BodyMotion(LIVELY, 4) for _ in range(2))
    first.at(50.0)  # what was asked before does not matter
    assert_allclose(first.at(3.3).T_rest_moved, again.at(3.3).T_rest_moved, atol=0.0)
    assert not np.allclose(first.at(3.3).T_rest_moved, BodyMotion(LIVELY, 5).at(3.3).T_rest_moved)


def test_seven_rays_take_about_a_quarter_millisecond(surface):
    origins, directions = rays_at_the_body(surface, 7, 9)
    surface.distance(origins, directions, 0.0)
    begun = time.perf_counter()
    for step in range(100):
        surface.distance(origins, directions, 0.01 * step)
    assert (time.perf_counter() - begun) / 100 < 5e-3  # far above the 0.3 ms of a quiet machine
