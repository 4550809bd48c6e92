import cv2
import numpy as np
import pytest
from bathbot_perception.training.data import augment
from bathbot_perception.training.data.augment import PHOTOMETRIC, photometric
from bathbot_perception.training.data.augment_geometry import (
    Example,
    GeometryRanges,
    flip,
    keep_visible,
    mosaic,
    move_boxes,
    place,
    random_placement,
    random_tilt,
    tilt,
)
from bathbot_perception.training.network.anchors import best_ratio, cluster_anchors
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

PICTURE = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
PAPER = {
    "random_pixels", "gaussian_noise", "occlusion", "pixel_zeroing", "salt_and_pepper", "gaussian_blur",
    "motion_blur", "adaptive_histogram_equalisation", "hsv", "contrast", "edge_enhancement", "brightness",
    "max_pooling", "average_pooling",
}  # fmt: skip


def square(left=20, top=10, right=50, bottom=40):
    """A white square on black, with its box."""
    picture = np.zeros((60, 80, 3), np.uint8)
    picture[top:bottom, left:right] = 255
    return Example(picture, np.array([[left, top, right, bottom]], dtype=float), np.array([4]))


def white_box(picture):
    rows, columns = np.nonzero(picture[..., 0] > 200)
    return [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]


@pytest.mark.parametrize("name", [function.__name__ for function, _ in PHOTOMETRIC])
@pytest.mark.parametrize("shape", [(60, 80, 3), (31, 7, 3)], ids=["wide", "narrow"])
def test_photometric_augmentations_keep_shape_type_and_source(name, shape):
    source = np.random.default_rng(1).integers(0, 256, shape, dtype=np.uint8)
    before = source.copy()
    result = getattr(augment, name)(source, np.random.default_rng(2))
    assert result.shape == shape
    assert result.dtype == np.uint8
    assert np.array_equal(source, before)
    assert not np.array_equal(result, before)


def test_every_photometric_augmentation_of_the_paper_is_there():
    assert {function.__name__ for function, _ in PHOTOMETRIC} >= PAPER


def test_a_seed_fixes_the_result():
    first, second = (photometric(PICTURE, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize("sideways", [True, False], ids=["sideways", "upside down"])
def test_boxes_follow_a_flip_and_two_flips_are_none(sideways):
    flipped = flip(square(), sideways)
    assert flipped.boxes[0].tolist() == white_box(flipped.picture)
    back = flip(flipped, sideways)
    assert np.array_equal(back.picture, square().picture)
    assert np.array_equal(back.boxes, square().boxes)


@given(st.floats(0.5, 2.0), st.floats(0.5, 2.0), st.floats(-10, 10), st.floats(-10, 10))
def test_boxes_follow_scale_and_shift_exactly(scale_u, scale_v, right, down):
    affine = np.array([[scale_u, 0.0, right], [0.0, scale_v, down]])
    boxes = np.array([[1.0, 2.0, 30.0, 40.0]])
    expected = [scale_u + right, 2 * scale_v + down, 30 * scale_u + right, 40 * scale_v + down]
    assert_allclose(move_boxes(boxes, affine)[0], expected, rtol=1e-9)


@given(st.floats(-3, 3))
def test_a_turned_box_holds_its_inscribed_ellipse(angle):
    affine = np.array([[np.cos(angle), -np.sin(angle), 5.0], [np.sin(angle), np.cos(angle), -3.0]])
    box = np.array([[10.0, 20.0, 50.0, 40.0]])
    around = np.linspace(0, 2 * np.pi, 721)
    ellipse = (
        np.stack([30 + 20 * np.cos(around), 30 + 10 * np.sin(around)], axis=1) @ affine[:, :2].T
        + affine[:, 2]
    )
    assert_allclose(move_boxes(box, affine)[0], [*ellipse.min(axis=0), *ellipse.max(axis=0)], atol=1e-3)


def test_the_drawn_square_is_where_its_box_says():
    placed = place(square(), (120, 160), np.array([[1.5, 0.0, 20.0], [0.0, 1.5, 10.0]]))
    assert placed.boxes[0] == pytest.approx(white_box(placed.picture), abs=1.0)


def test_a_picture_that_is_not_tilted_stays_and_a_shrunk_one_takes_its_box_along():
    corners = np.array([[0.0, 0.0], [80.0, 0.0], [80.0, 60.0], [0.0, 60.0]])
    assert_allclose(tilt(square(), corners).boxes, square().boxes, atol=1e-3)
    shrunk = tilt(square(), 0.5 * corners)
    assert_allclose(shrunk.boxes, 0.5 * square().boxes, atol=1e-3)
    assert shrunk.boxes[0] == pytest.approx(white_box(shrunk.picture[:30, :40]), abs=1.0)


@given(st.integers(0, 1000))
def test_a_tilted_disc_lies_in_its_box(seed):
    picture = np.zeros((60, 80, 3), np.uint8)
    cv2.ellipse(picture, (40, 30), (18, 12), 0, 0, 360, (255, 255, 255), -1)
    disc = Example(picture, np.array([[22.0, 18.0, 58.0, 42.0]]), np.array([1]))
    tilted = random_tilt(disc, 0.2, np.random.default_rng(seed))
    assert tilted.boxes[0] == pytest.approx(white_box(tilted.picture), abs=2.5)


def test_boxes_that_are_cut_off_are_dropped():
    example = square()._replace(
        boxes=np.array([[-90.0, 0.0, 10.0, 50.0], [-10.0, 0.0, 40.0, 50.0]]), classes=np.array([1, 2])
    )
    kept = keep_visible(example)
    assert kept.classes.tolist() == [2]
    assert kept.boxes.tolist() == [[0.0, 0.0, 40.0, 50.0]]


@given(st.integers(0, 1000))
def test_placed_and_mosaic_boxes_stay_on_the_canvas(seed):
    random = np.random.default_rng(seed)
    for example in (
        random_placement(square(), (96, 64), 1.0, GeometryRanges(), random),
        mosaic([square()] * 4, (96, 64), [1.0] * 4, GeometryRanges(), random),
    ):
        assert example.picture.shape == (96, 64, 3)
        assert np.all(example.boxes >= 0.0)
        assert np.all(example.boxes <= [64, 96, 64, 96])
        assert len(example.boxes) == len(example.classes)


def test_anchors_find_the_sizes_they_were_drawn_from():
    random = np.random.default_rng(3)
    true = np.array([[10.0, 20.0], [60.0, 30.0], [150.0, 200.0]])
    sizes = true[random.integers(0, 3, 600)] * np.exp(random.normal(0, 0.05, (600, 2)))
    assert_allclose(cluster_anchors(sizes, count=3), true, rtol=0.05)
    assert best_ratio(sizes, true).max() < 1.3
