"""Order of pictures by the lightness of skin."""

import cv2
import numpy as np
import pytest
from bathbot_perception.evaluation.skin_tone import thirds, typology_angle
from bathbot_perception.regions import Region
from hypothesis import given
from hypothesis import strategies as st


def skin(lightness, yellow):
    """A picture of one colour of CIELAB."""
    lab = np.full((60, 80, 3), (lightness, 12.0, yellow), np.float32)
    return np.clip(np.round(cv2.cvtColor(lab, cv2.COLOR_LAB2RGB) * 255.0), 0, 255).astype(np.uint8)


FACE = Region("Face_skin", 1.0, (20.0, 10.0, 60.0, 50.0))


@pytest.mark.parametrize(
    ("lightness", "yellow", "angle"), [(75.0, 15.0, 59.0), (60.0, 20.0, 26.6), (40.0, 18.0, -29.1)]
)
def test_the_angle_is_that_of_the_formula(lightness, yellow, angle):
    assert typology_angle(skin(lightness, yellow), [FACE]) == pytest.approx(angle, abs=1.5)


def test_a_face_counts_before_other_skin_and_only_its_middle():
    picture = skin(40.0, 18.0)
    picture[20:40, 30:50] = skin(70.0, 15.0)[20:40, 30:50]
    hand = Region("Hand_skin", 1.0, (0.0, 0.0, 80.0, 60.0))
    assert typology_angle(picture, [hand, FACE]) > 40.0
    assert np.isnan(typology_angle(picture, []))


@given(angles=st.lists(st.floats(-60.0, 80.0), min_size=3, max_size=60, unique=True))
def test_thirds_are_in_order_and_of_about_equal_size(angles):
    groups = thirds(angles)
    by_name = {name: [a for a, g in zip(angles, groups, strict=True) if g == name] for name in set(groups)}
    assert {"lightest", "darkest"} <= set(by_name)
    assert min(by_name["lightest"]) > max(by_name["darkest"])
    assert abs(len(by_name["lightest"]) - len(by_name["darkest"])) <= 1


def test_pictures_without_skin_belong_to_no_third():
    assert thirds([float("nan"), float("nan")]) == ["", ""]
    assert thirds([10.0, float("nan"), 50.0, 30.0])[1] == ""
