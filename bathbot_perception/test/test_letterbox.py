import numpy as np
import pytest
from bathbot_perception.detection.letterbox import GREY, STRIDE, Letterboxing, Scaling, fit_input, letterbox
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

sides = st.integers(1, 3000)
long_sides = st.integers(1, 20).map(lambda n: n * STRIDE)


@given(sides, sides, long_sides, st.lists(st.floats(0, 3000), min_size=4, max_size=4))
def test_boxes_return_to_the_picture(height, width, long_side, box):
    fit = fit_input((height, width), long_side)
    assert_allclose(fit.to_picture(fit.to_input(np.array(box))), box, atol=1e-6)


@given(sides, sides, long_sides)
def test_the_input_holds_the_picture_and_little_more(height, width, long_side):
    fit = fit_input((height, width), long_side)
    left, top, right, bottom = fit.to_input(np.array([0.0, 0.0, width, height]))
    assert fit.width % STRIDE == fit.height % STRIDE == 0
    assert max(fit.width, fit.height) == long_side
    assert -1e-6 <= left < STRIDE
    assert -1e-6 <= top < STRIDE
    assert fit.width - STRIDE < right <= fit.width + 1e-6
    assert fit.height - STRIDE < bottom <= fit.height + 1e-6


@given(st.integers(100, 3000), st.integers(100, 3000))
def test_the_picture_keeps_its_shape(height, width):
    fit = fit_input((height, width), 416)
    assert fit.scale_u == pytest.approx(
        fit.scale_v, abs=0.6 * fit.scale_u / min(fit.scale_u * width, fit.scale_v * height) + 1e-9
    )


def test_a_fixed_input_stays_as_it_is():
    fit = fit_input((480, 848), 416, fixed=(320, 416))
    assert (fit.height, fit.width) == (320, 416)
    assert (fit.left, fit.top) == (0, 42)


def test_padding_is_grey_and_the_picture_is_in_the_middle():
    fit = fit_input((480, 848), 416)
    tensor = letterbox(np.full((480, 848, 3), 255, np.uint8), fit)
    assert tensor.shape == (1, 3, 256, 416)
    assert tensor.dtype == np.float32
    assert_allclose(tensor[0, :, 0, :], GREY / 255.0, atol=1e-6)
    assert_allclose(tensor[0, :, 128, :], 1.0)


@given(st.integers(1, 90), st.integers(1, 90))
def test_pixels_and_values_are_the_same_picture(height, width):
    """Also where the padding is at the sides, and in memory used before."""
    pictures = np.random.default_rng(height).integers(0, 256, (2, height, width, 3), dtype=np.uint8)
    fit = fit_input((height, width), 64)
    letterboxing, scaling = Letterboxing((height, width), fit), Scaling()
    for picture in pictures:
        pixels = letterboxing(picture)
        assert pixels.shape == (1, 3, fit.height, fit.width)
        assert_allclose(scaling(pixels) * 255.0, pixels, atol=1e-4)
        assert_allclose(letterbox(picture, fit), scaling(pixels))
    if (fit.scale_u, fit.scale_v) == (1.0, 1.0):
        inside = pixels[0, :, fit.top : fit.top + height, fit.left : fit.left + width]
        assert (inside == picture.transpose(2, 0, 1)).all()


def test_channels_keep_their_order():
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[..., 0] = 255
    tensor = letterbox(picture, fit_input((64, 64), 64))
    assert tensor[0, :, 30, 30].tolist() == [1.0, 0.0, 0.0]
