import numpy as np
from bathbot_bringup.report.contact_measures import contact_measures, in_contact
from bathbot_bringup.report.coverage import coverage, patch_frame, skin_samples
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

TIMES, BAND = np.arange(0.0, 10.0, 0.02), (1.0, 6.0)


@settings(deadline=None)
@given(gap=st.floats(0.0, 1.0))
def test_the_contact_fraction_is_the_share_of_poses_passed_in_contact(gap):
    passed = np.linspace(1.0, 9.0, 401)
    compression = np.where(1.0 + 8.0 * gap > TIMES, -0.002, 0.005)
    measures = contact_measures(passed, TIMES, compression, 400.0 * np.maximum(compression, 0.0), BAND)
    assert_allclose(measures.fraction, 1.0 - gap, atol=0.01)


def test_poses_never_passed_count_as_not_scrubbed():
    passed = np.concatenate([np.linspace(1.0, 9.0, 100), np.full(100, np.nan)])
    assert_allclose(
        contact_measures(passed, TIMES, np.full(500, 0.005), np.full(500, 2.0), BAND).fraction, 0.5
    )


def test_forces_are_summed_up():
    force = np.where(TIMES < 5.0, 2.0, 7.0)
    force[0] = 9.0  # before the path: counts for the peak only
    measures = contact_measures(np.linspace(1.0, 9.0, 401), TIMES, np.full(500, 0.005), force, BAND)
    assert measures.force_peak == 9.0
    assert_allclose(measures.comfort_fraction, 0.5, atol=0.01)
    assert_allclose(measures.force_mean, 4.5, atol=0.05)


def test_without_samples_nothing_was_in_contact():
    assert not in_contact([1.0, 2.0], [], []).any()
    measures = contact_measures([np.nan], [], [], [], BAND)
    assert measures.fraction == 0.0
    assert np.isnan(measures.force_peak)


def sheet(size=0.3, cells=60):
    """A flat skin in the plane z = 0, seen from below (outward is -z), as a mesh."""
    axis = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (
        index[:-1, :-1].ravel(),
        index[1:, :-1].ravel(),
        index[1:, 1:].ravel(),
        index[:-1, 1:].ravel(),
    )
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int32)
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1), faces


def frame_path(half=0.05, count=80):
    """Poses around a square, z into the skin (+z)."""
    side = np.linspace(-half, half, count)
    points = np.concatenate([
        np.stack([side, np.full(count, -half)], 1), np.stack([np.full(count, half), side], 1),
        np.stack([side[::-1], np.full(count, half)], 1), np.stack([np.full(count, -half), side[::-1]], 1),
    ])  # fmt: skip
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    poses[:, :2, 3] = points
    return poses


def test_a_brush_around_a_square_leaves_its_middle_uncovered():
    vertices, faces = sheet()
    poses = frame_path()
    result = coverage(
        poses,
        faces,
        np.ones(len(faces), dtype=bool),
        lambda t: vertices,
        np.arange(len(poses)) * 0.05,
        poses[:, :3, 3],
    )
    assert_allclose(result.fraction, 0.75, atol=0.04)  # a hole of 5 cm in a square of 10 cm


def test_the_body_may_move_while_it_is_washed():
    vertices, faces = sheet()
    poses = frame_path()
    times = np.arange(len(poses)) * 0.05
    drift = np.array([0.0, 0.0, 0.002])
    moving = coverage(
        poses, faces, np.ones(len(faces), dtype=bool), lambda t: vertices + t * drift, times,
        poses[:, :3, 3] + times[:, None] * drift,
    )  # fmt: skip
    assert_allclose(moving.fraction, 0.75, atol=0.05)


def test_no_path_covers_nothing_that_could_be_named():
    vertices, faces = sheet()
    empty = coverage(np.zeros((0, 4, 4)), faces, np.ones(len(faces), dtype=bool), lambda t: vertices, [], [])
    assert np.isnan(empty.fraction)


def test_the_patch_frame_is_right_handed_and_looks_into_the_skin():
    frame = patch_frame(frame_path())
    assert_allclose(np.linalg.det(frame.axes), 1.0)
    assert_allclose(frame.axes[2], [0.0, 0.0, 1.0])
    assert_allclose(frame.flatten(frame.origin), 0.0, atol=1e-12)


def test_samples_stand_for_equal_areas():
    vertices, faces = sheet()
    half = vertices[faces].mean(axis=1)[:, 0] > 0.0
    triangles, weights = skin_samples(vertices, faces, half)
    assert_allclose(weights.sum(axis=1), 1.0)
    assert half[triangles].all()
    assert_allclose(len(triangles) * 0.003**2, 0.045, rtol=0.01)
