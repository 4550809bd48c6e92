"""What a privacy profile lets through: topics, types, sizes, and what stands in a message."""

import datetime
from pathlib import Path

import numpy as np
import pytest
from bathbot_bringup.bag.message_types import installed_types
from bathbot_bringup.bag.recording.content import Bounds
from bathbot_bringup.bag.recording.privacy import PICTURE_TYPES, Consent, find_profile, load_profiles
from bathbot_bringup.errors import InputError, SettingsError
from bathbot_scrub.installed_arm import installed_arm
from hypothesis import given, settings
from hypothesis import strategies as st

FILE = Path(__file__).parents[1] / "config" / "privacy_profiles.yaml"
PICTURE = "sensor_msgs/msg/Image"
AGREED = Consent("A. Example", "2026-01-31", "gait study")
BOUNDS = Bounds(1000, 120, 12)
TYPES = installed_types().types


def metrics():
    return find_profile(FILE, "metrics_only")


@settings(deadline=None)
@given(topic=st.text(min_size=1), kind=st.sampled_from(sorted(PICTURE_TYPES)))
def test_no_profile_without_pictures_ever_lets_one_through(topic, kind):
    for profile in load_profiles(FILE).values():
        assert profile.pictures or profile.bounds(topic, kind) is None


@pytest.mark.parametrize("topic", ["/arm_state", "/left/arm_state"])
def test_numbers_are_taken_from_any_namespace_by_their_type_only(topic):
    assert metrics().bounds(topic, "bathbot_msgs/msg/ArmState")
    assert metrics().bounds(topic, "std_msgs/msg/String") is None


def test_the_description_of_the_arm_is_taken_to_the_letter_and_no_other_long_text():
    bounds = metrics().bounds("/robot_description", "std_msgs/msg/String")
    string = TYPES["std_msgs/msg/String"]
    for variant in ("B", "6F", "6FB"):
        urdf = installed_arm(variant).description()
        assert len(urdf) + 9 < bounds.size
        assert bounds.refusal(string(urdf)) == ""
        assert "a text of" in bounds.refusal(string(urdf[:-1] + "x"))


def test_a_known_text_that_nobody_knows_is_refused(tmp_path):
    file = tmp_path / "profiles.yaml"
    topic = "{topic: /a, type: std_msgs/msg/String, bytes: 9, known: poems}"
    file.write_text(f"mine: {{about: x, pictures: false, topics: [{topic}]}}")
    with pytest.raises(InputError, match="no file of privacy profiles"):
        load_profiles(file)


def test_what_is_not_named_is_not_taken():
    assert metrics().bounds("/my_secret", "std_msgs/msg/String") is None


def test_where_a_type_is_named_no_other_passes_in_any_profile():
    for name in ("metrics_only", "depth_only", "full"):
        profile = find_profile(FILE, name)
        assert profile.bounds("/tf", "tf2_msgs/msg/TFMessage")
        assert profile.bounds("/tf", PICTURE) is None


def test_all_types_that_are_named_exist():
    named = {entry.message_type for profile in load_profiles(FILE).values() for entry in profile.entries}
    assert named - {"*"} <= set(installed_types().fielddefs)


def test_depth_only_takes_depth_and_no_colour():
    profile = find_profile(FILE, "depth_only")
    assert profile.bounds("/camera/camera/depth/image_rect_raw", PICTURE)
    assert profile.bounds("/arm_state", "bathbot_msgs/msg/ArmState")
    assert profile.bounds("/camera/camera/color/image_raw", PICTURE) is None


def test_pictures_ask_who_agreed_when_and_why():
    profile = find_profile(FILE, "full")
    assert profile.bounds("/camera/camera/color/image_raw", PICTURE)
    profile.check_consent(AGREED)
    to_come = (datetime.date.today() + datetime.timedelta(days=1)).isoformat()
    for wrong, said in [
        (AGREED._replace(who=" "), "does not say who"),
        (AGREED._replace(when="yesterday"), "'yesterday', no date"),
        (AGREED._replace(when=to_come), "a day to come"),
        (AGREED._replace(when="", why=""), "does not say when and why"),
    ]:
        with pytest.raises(SettingsError, match=said):
            profile.check_consent(wrong)


def test_an_unknown_profile_lists_those_that_exist():
    with pytest.raises(SettingsError, match="'everything'; there are depth_only, full, metrics_only"):
        find_profile(FILE, "everything")


LOOP = "x: {about: a, pictures: false, topics: [], include: x}"


@pytest.mark.parametrize("text", ["", "[1, 2]", "default: 3", "default: {about: x}", "{", LOOP])
def test_a_file_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "profiles.yaml").write_text(text)
    with pytest.raises(InputError, match="profiles"):
        load_profiles(tmp_path / "profiles.yaml")


def test_pictures_must_be_said_plainly(tmp_path):
    """A misspelt switch must not open the door."""
    entry = "{topic: '*', type: '*', bytes: 9}"
    (tmp_path / "p.yaml").write_text(f"x: {{about: a, topics: [{entry}], pictures: yess}}")
    profile = load_profiles(tmp_path / "p.yaml")["x"]
    assert not profile.pictures
    assert profile.bounds("/color", PICTURE) is None


def joint_state(names=("joint1",), position=(0.5,)):
    stamp = TYPES["builtin_interfaces/msg/Time"](1, 2)
    header = TYPES["std_msgs/msg/Header"](stamp, "base_link")
    numbers = np.array(position, dtype=float)
    return TYPES["sensor_msgs/msg/JointState"](header, list(names), numbers, numbers, numbers)


def test_what_is_measured_and_said_passes():
    state = joint_state(("joint1", "joint2"), (0.0, -3.1, float("nan"), 1e-17, float("inf")))
    assert BOUNDS.refusal(state) == ""
    assert BOUNDS.refusal(TYPES["std_msgs/msg/String"]("Trunk_skin ist 12 \u00b0C warm \u2192 gut")) == ""


NUMBERS = np.frombuffer(bytes(range(1, 97)), dtype=float)


@pytest.mark.parametrize(("message", "said"), [
    pytest.param(joint_state(["a" * 121]), "name is a text of 121 characters", id="long text"),
    pytest.param(joint_state(["/9j/4AAQSkZJRg" * 7]), "holds what no person writes", id="base64"),
    pytest.param(joint_state(["\x89PNG"]), "holds what no person writes", id="bytes as text"),
    pytest.param(joint_state(["a"] * 13), "name has 13 entries", id="many texts"),
    pytest.param(joint_state(position=[0.1] * 13), "position has 13 entries", id="many numbers"),
    pytest.param(joint_state(position=NUMBERS), "which nobody measures", id="bytes as numbers"),
    pytest.param(joint_state(position=np.array([0x7FF8000000001234], "u8").view(float)),
                 "hides something in what is no number", id="bytes in NaN"),
])  # fmt: skip
def test_a_picture_in_disguise_is_refused(message, said):
    assert said in BOUNDS.refusal(message)


@given(st.binary(min_size=96, max_size=96))
def test_random_bytes_are_no_twelve_measured_numbers(data):
    """Each of the twelve looks measured with a chance of one in ten."""
    numbers = np.frombuffer(data, dtype=float)
    plain = all(number == 0.0 or 1e-30 < abs(number) < 1e7 for number in numbers)
    assert plain or BOUNDS.refusal(joint_state(position=numbers))
