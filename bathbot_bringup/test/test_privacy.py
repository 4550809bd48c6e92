from pathlib import Path

import pytest
from bathbot_bringup.bag.privacy import IMAGE_TYPES, find_profile, load_profiles
from bathbot_bringup.errors import InputError, SettingsError
from hypothesis import given, settings
from hypothesis import strategies as st

FILE = Path(__file__).parents[1] / "config" / "privacy_profiles.yaml"
PICTURE = "sensor_msgs/msg/Image"


@settings(deadline=None)
@given(topic=st.text(min_size=1), kind=st.sampled_from(sorted(IMAGE_TYPES)))
def test_no_profile_without_images_ever_lets_a_picture_through(topic, kind):
    for profile in load_profiles(FILE).values():
        assert profile.images or not profile.allows(topic, kind)


@pytest.mark.parametrize("topic", ["/arm_state", "/left/arm_state", "/contact_targets", "/tf_static"])
def test_the_default_profile_takes_numbers_from_any_namespace(topic):
    assert find_profile(FILE, "default").allows(topic, "some_msgs/msg/Thing")


def test_the_default_profile_takes_nothing_it_does_not_name():
    assert not find_profile(FILE, "default").allows("/my_secret", "std_msgs/msg/String")


def test_calibration_takes_pictures_but_asks_for_consent():
    profile = find_profile(FILE, "calibration")
    assert profile.allows("/camera/camera/depth/image_rect_raw", PICTURE)
    with pytest.raises(SettingsError, match="say who agreed"):
        profile.check_consent("  ")
    profile.check_consent("A. Example, in writing")


def test_an_unknown_profile_lists_those_that_exist():
    with pytest.raises(SettingsError, match="'everything'; there are arm, calibration, default"):
        find_profile(FILE, "everything")


@pytest.mark.parametrize("text", ["", "[1, 2]", "default: 3", "default: {about: x}", "{"])
def test_a_file_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "profiles.yaml").write_text(text)
    with pytest.raises(InputError, match="profiles"):
        load_profiles(tmp_path / "profiles.yaml")


def test_images_must_be_said_plainly(tmp_path):
    """A misspelt switch must not open the door."""
    (tmp_path / "p.yaml").write_text("x: {about: a, topics: ['*'], images: yess}")
    assert not load_profiles(tmp_path / "p.yaml")["x"].images
