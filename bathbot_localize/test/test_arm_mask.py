"""The arm's mask: every point of the widened arm falls inside it, and little else does."""

from itertools import pairwise

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import inverse, transform_from, transform_points
from bathbot_localize.arm import arm_shape
from bathbot_localize.arm.arm_mask import arm_silhouette, near_arm, project_widely
from bathbot_localize.arm.arm_shape import ArmCapsule, UnknownArmError
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import COLOUR, T_BASE_COLOUR
from rm65_links import SHAPE, links_of
from scipy.spatial.transform import Rotation

MARGIN = 0.02


def points_of(capsule, margin, rng, count=200):
    """Random points inside a widened capsule, in its link's frame."""
    start, end = np.array(capsule.start), np.array(capsule.end)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return (
        start
        + rng.random((count, 1)) * (end - start)
        + direction * (capsule.radius + margin) * rng.random((count, 1))
    )


@settings(max_examples=25, deadline=None)
@given(q=st.tuples(*[st.floats(-2.0, 2.0)] * 6), seed=st.integers(0, 1000))
def test_projected_points_of_the_arm_are_inside_the_mask(q, seed):
    rng, links = np.random.default_rng(seed), links_of(q)
    mask = arm_silhouette(SHAPE.capsules, links, T_BASE_COLOUR, COLOUR, MARGIN)
    for capsule in SHAPE.capsules:
        points_base = transform_points(links[capsule.link], points_of(capsule, MARGIN, rng))
        assert near_arm(points_base, SHAPE.capsules, links, MARGIN).all()
        points = transform_points(inverse(T_BASE_COLOUR), points_base)
        # What reaches the lens itself is out of the drawing's range; no arm pose puts it there.
        pixels = np.rint(COLOUR.project(points[points[:, 2] > 0.2]))
        tangent = np.linalg.norm(points[points[:, 2] > 0.2, :2] / points[points[:, 2] > 0.2, 2:], axis=1)
        inside = ((pixels >= 0) & (pixels < (COLOUR.width, COLOUR.height))).all(axis=1) & (tangent < 1.3)
        u, v = pixels[inside].astype(int).T
        assert mask[v, u].mean() > 0.99 if len(u) else True


def test_a_sphere_covers_the_disc_it_should():
    """A sphere of 0.1 m at 1 m on the axis: its outline has radius f tan(asin 0.1) = 21 px."""
    ball = ArmCapsule("ball", (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0.08)
    mask = arm_silhouette((ball,), {"ball": np.eye(4)}, np.eye(4), COLOUR, 0.02)
    expected = np.pi * COLOUR.fx * COLOUR.fy * np.tan(np.arcsin(0.1)) ** 2
    assert expected * 0.98 < mask.sum() < expected * 1.08


def test_an_arm_behind_the_camera_covers_nothing():
    ball = ArmCapsule("ball", (0.0, 0.0, -1.0), (0.1, 0.0, -0.5), 0.05)
    assert not arm_silhouette((ball,), {"ball": np.eye(4)}, np.eye(4), COLOUR, 0.02).any()


def test_links_that_are_missing_cover_nothing():
    assert not arm_silhouette(SHAPE.capsules, {}, T_BASE_COLOUR, COLOUR).any()
    assert not near_arm(np.zeros((3, 3)), SHAPE.capsules, {}).any()


def test_unknown_points_are_not_near():
    assert not near_arm(np.full((2, 2, 3), np.nan), SHAPE.capsules, links_of(np.zeros(6))).any()


def test_a_wider_margin_only_adds_pixels():
    links = links_of((0.5, 0.9, -1.6, 0.2, -1.0, 0.3))
    narrow, wide = (
        arm_silhouette(SHAPE.capsules, links, T_BASE_COLOUR, COLOUR, margin) for margin in (0.0, 0.03)
    )
    assert narrow.any()
    assert (wide | ~narrow).all()
    assert wide.sum() > narrow.sum()


@pytest.mark.parametrize(
    ("point", "distance"), [((0.5, 0.2, 0.0), 0.2), ((2.0, 0.0, 0.0), 1.0), ((-3.0, 4.0, 0.0), 5.0)]
)
def test_distance_to_a_rod_by_hand(point, distance):
    bar = ArmCapsule("bar", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.1)
    near = [
        near_arm(np.array([point]), (bar,), {"bar": np.eye(4)}, distance - 0.1 + step)[0]
        for step in (-1e-6, 1e-6)
    ]
    assert near == [False, True]


def test_a_lens_does_not_fold_far_points_back_into_the_picture():
    """At 63 degrees off the axis this lens's polynomial is negative; an elbow there must stay on its side."""
    points = np.array([[2.0 * share, 0.3 * share, 1.0] for share in np.linspace(0.1, 1.5, 30)])
    assert (np.diff(project_widely(COLOUR, points)[:, 0]) > 0.0).all()
    inside = points[:10]
    np.testing.assert_allclose(project_widely(COLOUR, inside), COLOUR.project(inside))


def test_the_folded_arm_beside_the_camera_leaves_most_of_the_picture_open():
    links = links_of(np.radians([0.0, 60.0, -130.0, 0.0, -80.0, 0.0]))
    assert arm_silhouette(SHAPE.capsules, links, T_BASE_COLOUR, COLOUR, MARGIN).mean() < 0.45


def test_neighbouring_capsules_touch_and_the_brush_ends_at_the_tip():
    """In any posture each capsule reaches the next one: the arm has no gaps."""
    links = links_of((0.3, -0.8, 1.2, 0.4, 0.9, -0.5))
    ends = [transform_points(links[c.link], [c.start, c.end]) for c in SHAPE.capsules]
    for (first, here), (second, following) in pairwise(zip(SHAPE.capsules, ends, strict=True)):
        ends_meet = np.linalg.norm(following[0] - here[1])
        assert ends_meet <= first.radius + second.radius, f"{first.link} to {second.link}"
    tip = SHAPE.capsules[-1]
    assert tip.end[2] + tip.radius == pytest.approx(0.0)
    head = links["scrub_head"] @ transform_from(translation=(0.0, 0.0, -0.10))
    np.testing.assert_allclose(head, links["Link6"], atol=1e-12)


def test_the_mask_follows_the_camera():
    """Moving arm and camera together leaves the picture as it is."""
    move = transform_from(Rotation.from_rotvec([0.4, 0.2, -0.9]).as_matrix(), (0.3, -0.5, 0.7))
    links = links_of((0.5, 0.9, -1.6, 0.2, -1.0, 0.3))
    moved = {name: move @ pose for name, pose in links.items()}
    first = arm_silhouette(SHAPE.capsules, links, T_BASE_COLOUR, COLOUR)
    second = arm_silhouette(SHAPE.capsules, moved, move @ T_BASE_COLOUR, COLOUR)
    assert np.count_nonzero(first != second) <= 0.02 * first.sum()


def test_an_arm_that_nobody_knows_is_said_by_name(monkeypatch):
    monkeypatch.setattr(arm_shape, "INSTALLED_ARM", "bathbot_nowhere.installed_arm")
    with pytest.raises(UnknownArmError, match=r"bathbot_nowhere.installed_arm .* install bathbot_scrub"):
        arm_shape.installed_shape()
