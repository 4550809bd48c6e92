"""How deep a path may press, from what camera and force know of the skin."""

import tracemalloc

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import transform_points
from bathbot_scrub.arm.errors import InvalidPoseError
from bathbot_scrub.arm.force_limits import RegionLimits, shipped_force_limits
from bathbot_scrub.rm65.motion.path_depth import (
    CURVING,
    FARTHEST,
    MOST_TILT,
    TOLERANCE,
    Bristles,
    Felt,
    Skin,
    check_depth,
    depths,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from synthetic_skin import somewhere

BRISTLES = Bristles(contact=1.0, stiffness=400.0)  # 1 N bends them by 2.5 mm
GIVE, NOWHERE = 0.010, np.empty((0, 3))
FLAT = np.array([[x, y, 0.0] for x in np.arange(-0.1, 0.11, 0.02) for y in np.arange(-0.1, 0.11, 0.02)])


def head(depth=0.0, x=0.0, y=0.0, tilt=0.0):
    """A head over the plane z = 0, skin below it; its z axis points down, the tip is `depth` [m] below."""
    c, s = np.cos(tilt), np.sin(tilt)
    pose = np.eye(4)
    pose[:3, :3] = np.array([[c, 0.0, -s], [0.0, -1.0, 0.0], [-s, 0.0, -c]])
    pose[:3, 3] = x, y, -depth
    return pose


def felt(force=1.0, depth=None):
    """Skin at z = 0 felt with a force [N]."""
    return Felt(head(force / 400.0 if depth is None else depth), force)


def skin(cloud=NOWHERE, now=None):
    return Skin(felt(), now or felt(), cloud)


def refused(*poses, known):
    with pytest.raises(InvalidPoseError) as caught:
        check_depth(np.stack(poses), known, BRISTLES)
    return str(caught.value)


def test_by_hand_on_flat_skin_that_is_felt_and_seen():
    """1 N bends the bristles by 2.5 mm: the skin is there; 18 mm below it is the most."""
    for cloud in (NOWHERE, FLAT):
        found = depths(np.stack([head(0.005), head(0.018), head(-0.03)]), skin(cloud), BRISTLES)
        assert_allclose(found.depth, [0.005, 0.018, -0.03], atol=1e-6)
        assert_allclose(found.most, GIVE + TOLERANCE)
        check_depth(np.stack([head(0.005), head(0.0179), head(-0.03)]), skin(cloud), BRISTLES)
        assert "pose 1 of 2 lies 19 mm below" in refused(head(0.005), head(0.0192), known=skin(cloud))
        assert "40 mm below" in refused(head(0.04), known=skin(cloud))


def test_by_hand_what_the_cloud_does_not_show_may_curve_away_from_the_touch():
    """30 mm beside it by 7.5 mm, where it curves with 60 mm; never by more than 20 mm."""
    found = depths(np.stack([head(0.01, x=0.03), head(0.01, y=0.2)]), skin(), BRISTLES)
    assert not found.seen.any()
    assert_allclose(found.most - GIVE - TOLERANCE, [0.03**2 / (2.0 * CURVING), FARTHEST])
    assert "no body cloud is there" in refused(head(0.039, y=0.2), known=skin())


def test_where_the_cloud_shows_skin_the_touch_far_away_does_not_count():
    sloping = FLAT - np.outer(0.5 * np.maximum(FLAT[:, 0], 0.0), [0.0, 0.0, 1.0])
    at = head(0.045, x=0.08)  # 5 mm below the skin there
    assert depths(at[None], skin(sloping), BRISTLES).depth[0] == pytest.approx(0.005, abs=0.003)
    check_depth(at[None], skin(sloping), BRISTLES)
    refused(head(0.065, x=0.08), known=skin(sloping))
    refused(at, known=skin(FLAT))


@pytest.mark.parametrize("off", [-0.008, 0.008])
def test_the_force_says_how_far_the_cloud_is_off(off):
    cloud = FLAT + np.array([0.0, 0.0, off])
    assert depths(head(0.005)[None], skin(cloud), BRISTLES).depth[0] == pytest.approx(0.005, abs=1e-4)


def test_skin_that_is_not_felt_where_the_cloud_has_it_lies_deeper():
    """The person has moved back by 12 mm; the head, 9 mm below the old place, feels nothing."""
    nothing = Felt(head(0.009), 0.1)
    assert depths(head(0.02)[None], skin(FLAT, nothing), BRISTLES).depth[0] == pytest.approx(0.011, abs=5e-4)
    assert depths(head(0.02)[None], skin(NOWHERE, nothing), BRISTLES).depth[0] == pytest.approx(
        0.011, abs=5e-4
    )
    over = Felt(head(-0.03), 0.1)  # it hovers: that tells nothing
    assert depths(head(0.005)[None], skin(FLAT, over), BRISTLES).depth[0] == pytest.approx(0.005, abs=1e-4)


def test_camera_and_force_cannot_talk_each_other_far_away():
    """However far they disagree, the force moves the skin of the camera by 20 mm."""
    deep = Felt(head(0.06), 1.0)
    assert depths(head(0.05)[None], skin(FLAT, deep), BRISTLES).depth[0] == pytest.approx(0.03, abs=1e-3)


def test_a_force_that_is_no_number_tells_nothing():
    found = depths(head(0.005)[None], skin(FLAT, Felt(head(0.002), np.nan)), BRISTLES)
    assert found.depth[0] == pytest.approx(0.005, abs=1e-4)


@pytest.mark.parametrize("cloud", [NOWHERE, FLAT], ids=["unseen", "seen"])
def test_a_head_that_does_not_point_into_the_skin_is_refused(cloud):
    check_depth(head(0.003, tilt=MOST_TILT - 0.05)[None], skin(cloud), BRISTLES)
    assert "70 deg past the skin's normal" in refused(head(0.003, tilt=np.radians(70.0)), known=skin(cloud))
    assert "180 deg past" in refused(head(0.003, tilt=np.pi), known=skin(cloud))


def test_a_normal_that_the_camera_knows_counts_beside_that_of_the_touch():
    """On a flank of 60 deg a head 20 deg off the touch, to the wrong side, is 80 deg off the skin."""
    c, s = np.cos(np.radians(60.0)), np.sin(np.radians(60.0))
    flank = FLAT @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]]) + np.array([0.15, 0.0, -0.1])
    for tilt, off in ((-20.0, 80.0), (20.0, 40.0)):
        at = head(0.1, x=0.15, tilt=np.radians(tilt))[None]
        assert depths(at, skin(), BRISTLES).tilt[0] == pytest.approx(np.radians(20.0))
        assert depths(at, skin(flank), BRISTLES).tilt[0] == pytest.approx(np.radians(off))


poses = st.lists(
    st.tuples(st.floats(-0.01, 0.03), st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)), min_size=1, max_size=8
)


@given(places=poses, seed=st.integers(0, 1000), seen=st.booleans())
@settings(max_examples=60, deadline=None)
def test_where_the_arm_stands_is_all_the_same(places, seed, seen):
    """Law: moved together in space, depths and bounds are as they were."""
    T, cloud = somewhere(seed), FLAT + np.random.default_rng(seed).normal(0.0, 0.003, FLAT.shape)
    heads, known = np.stack([head(*place) for place in places]), skin(cloud if seen else NOWHERE)
    moved = Skin(
        Felt(T @ known.touch.T_base_head, 1.0),
        Felt(T @ known.now.T_base_head, 1.0),
        transform_points(T, known.cloud),
    )
    for one, other in zip(depths(heads, known, BRISTLES), depths(T @ heads, moved, BRISTLES), strict=True):
        assert_allclose(one, other, atol=1e-7)


def test_many_poses_and_a_large_cloud_are_judged_as_a_few_are_and_in_little_memory():
    rng = np.random.default_rng(0)
    cloud = np.concatenate([FLAT, rng.uniform((-1.0, -1.0, 1.0), (1.0, 1.0, 3.0), (80_000, 3))])
    heads = np.stack([head(0.001 * i % 0.02, x=0.0001 * i) for i in range(500)])
    tracemalloc.start()
    many = depths(heads, skin(cloud), BRISTLES)
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()
    for i in (0, 63, 64, 250, 499):
        few = depths(heads[i : i + 1], skin(FLAT), BRISTLES)
        assert_allclose([many.depth[i], many.tilt[i]], [few.depth[0], few.tilt[0]], atol=1e-9)


@given(places=poses, seed=st.integers(0, 1000), deeper=st.floats(0.001, 0.02), seen=st.booleans())
@settings(max_examples=60, deadline=None)
def test_deeper_is_deeper(places, seed, deeper, seen):
    """Law: pushed in by some millimetres, no pose is nearer to being allowed by more than noise."""
    cloud = FLAT + np.random.default_rng(seed).normal(0.0, 0.002, FLAT.shape)
    heads, known = np.stack([head(*place) for place in places]), skin(cloud if seen else NOWHERE)
    pushed = heads + deeper * np.pad(heads[:, :3, 2:3], ((0, 0), (0, 1), (3, 0)))
    before, after = depths(heads, known, BRISTLES), depths(pushed, known, BRISTLES)
    assert_allclose(after.depth - after.most - (before.depth - before.most), deeper, atol=1e-6)


@given(
    radius=st.floats(0.04, 0.3),
    force=st.floats(1.0, 3.5),
    seed=st.integers(0, 1000),
    at=st.floats(-0.5, 0.5),
    off=st.floats(-0.01, 0.01),
)
@settings(max_examples=100, deadline=None)
def test_on_round_skin_what_is_planned_passes_and_what_would_hurt_does_not(radius, force, seed, at, off):
    """Law: on a limb of any radius, the cloud off by up to 10 mm and noisy, 5 mm pass and 30 mm never do."""
    rng = np.random.default_rng(seed)
    angles, along = np.meshgrid(
        np.arange(-np.pi / 2, np.pi / 2, 0.02 / radius), np.arange(-0.1, 0.1, 0.02), indexing="ij"
    )
    points = np.stack(
        [radius * np.sin(angles), along, radius * np.cos(angles) - radius + off], axis=-1
    ).reshape(-1, 3)
    cloud = points + rng.normal(0.0, 0.0015, points.shape)
    known = skin(cloud, felt(force))

    def pressed(depth):
        pose = head(tilt=at)
        pose[:3, 3] = [radius * np.sin(at), 0.0, radius * np.cos(at) - radius]
        pose[:3, 3] += depth * pose[:3, 2]
        return pose

    check_depth(np.stack([pressed(0.005), pressed(-0.02)]), known, BRISTLES)
    refused(pressed(0.03), known=known)


def test_the_stricter_of_two_limits_holds_for_both():
    limits = list(shipped_force_limits().regions.values())
    for one in limits:
        for other in limits:
            both = one.stricter(other)
            assert isinstance(both, RegionLimits)  # in order, or it would have been refused
            assert both == other.stricter(one)
            assert one.stricter(one) == one
            for name in ("retract", "hard_stop", "torque", "collision"):
                assert getattr(both, name) == min(getattr(one, name), getattr(other, name))
