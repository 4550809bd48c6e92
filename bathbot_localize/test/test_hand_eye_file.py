"""The hand-eye file: what is written is read, and bad files are refused in one line."""

import numpy as np
import pytest
import yaml
from bathbot_localize.hand_eye.calibration_file import HandEye, HandEyeFileError, load_hand_eye, save_hand_eye
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import T_BASE_COLOUR
from scipy.spatial.transform import Rotation


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_what_is_written_is_read(seed, tmp_path_factory):
    rng = np.random.default_rng(seed)
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = (
        Rotation.random(random_state=rng).as_matrix(),
        rng.uniform(-2.0, 2.0, 3),
    )
    path = tmp_path_factory.mktemp("hand_eye") / "hand_eye.yaml"
    save_hand_eye(HandEye(transform, 0.2, 0.3, 12, 25.0, "2025-06-01"), path)
    loaded = load_hand_eye(path)
    np.testing.assert_allclose(loaded.T_base_camera, transform, atol=1e-12)
    assert loaded[1:] == (0.2, 0.3, 12, 25.0, "2025-06-01")


def test_the_file_is_plain_for_people(tmp_path):
    save_hand_eye(HandEye(T_BASE_COLOUR, date="2025-06-01"), tmp_path / "a.yaml")
    document = yaml.safe_load((tmp_path / "a.yaml").read_text())
    assert document["parent"] == "base_link"
    assert document["child"] == "camera_color_optical_frame"
    assert document["translation"] == pytest.approx(T_BASE_COLOUR[:3, 3].tolist())


def test_an_old_file_is_replaced_whole_and_nothing_else_stays(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("old")
    save_hand_eye(HandEye(T_BASE_COLOUR), path)
    assert [file.name for file in tmp_path.iterdir()] == ["a.yaml"]
    np.testing.assert_allclose(load_hand_eye(path).T_base_camera, T_BASE_COLOUR, atol=1e-12)


def test_a_folder_that_is_missing_is_refused(tmp_path):
    with pytest.raises(HandEyeFileError, match="is the folder there"):
        save_hand_eye(HandEye(T_BASE_COLOUR), tmp_path / "no" / "a.yaml")


GOOD = {
    "kind": "bathbot hand-eye", "parent": "base_link", "child": "camera_color_optical_frame",
    "translation": [0.1, 0.2, 0.6], "quaternion_xyzw": [0.0, 0.0, 0.0, 1.0],
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "something"}, "of kind 'something'"),
        ({"parent": "world"}, "expected camera_color_optical_frame to base_link"),
        ({"translation": [0.1, 0.2]}, "translation must be 3 numbers"),
        ({"translation": [0.1, 0.2, float("nan")]}, "translation must be 3 numbers"),
        ({"translation": [100.0, 0.2, 600.0]}, "no pose of a camera"),
        ({"quaternion_xyzw": [0.0, 0.0, 0.0, 0.0]}, "no pose of a camera"),
        ({"quaternion_xyzw": None}, "quaternion_xyzw must be 4 numbers"),
    ],
)
def test_bad_content_is_refused_in_one_line(change, message, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(yaml.safe_dump(GOOD | change))
    with pytest.raises(HandEyeFileError, match=message) as refused:
        load_hand_eye(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"[1, 2", b"\xff\xfe\x00\x81", b"just words"])
def test_a_file_of_another_kind_is_refused_in_one_line(content, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(content)
    with pytest.raises(HandEyeFileError, match="calibrate hand-eye") as refused:
        load_hand_eye(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("path", ["", "/nowhere/hand_eye.yaml", "/"])
def test_a_missing_file_names_the_command_that_makes_one(path):
    with pytest.raises(HandEyeFileError, match="bathbot calibrate hand-eye"):
        load_hand_eye(path)
