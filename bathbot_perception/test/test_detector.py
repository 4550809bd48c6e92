import json

import numpy as np
import pytest
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.detector import load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.errors import ModelError, PictureError, SettingsError
from bathbot_perception.regions import area, overlap
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from skimage.data import astronaut
from tiny_model import row

HAND = row("Hand_skin", 0.9, (32.0, 24.0), (16.0, 8.0))
ASTRONAUT_FACE = np.array([180.0, 70.0, 270.0, 180.0])


def test_boxes_are_given_in_the_picture(write_model):
    """A picture of 128x64 px enters a 64 px network at half its size, 0 px from the top."""
    region = load(write_model([HAND])).detect(np.zeros((64, 128, 3), np.uint8))[0]
    assert region.name == "Hand_skin"
    assert region.score == pytest.approx(0.9)
    assert region.box == pytest.approx((48.0, 40.0, 80.0, 56.0))


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(height=st.integers(1, 300), width=st.integers(1, 300))
def test_boxes_stay_inside_any_picture(write_model, height, width):
    big = row("Trunk_skin", 0.8, (32.0, 32.0), (90.0, 90.0))
    for region in load(write_model([big, HAND])).detect(np.zeros((height, width, 3), np.uint8)):
        left, top, right, bottom = region.box
        assert 0.0 <= left < right <= width
        assert 0.0 <= top < bottom <= height


def test_settings_decide_what_is_kept(write_model):
    near = row("Hand_skin", 0.7, (33.0, 24.0), (16.0, 8.0))
    faint = row("Foot_skin", 0.3, (10.0, 10.0), (8.0, 8.0))
    model, picture = write_model([HAND, near, faint]), np.zeros((64, 64, 3), np.uint8)

    def names(**values):
        return [region.name for region in load(model, SkinDetectorSettings(**values)).detect(picture)]

    assert names() == ["Hand_skin"]
    assert names(overlap_limit=1.0) == ["Hand_skin", "Hand_skin"]
    assert names(score_threshold=0.2) == ["Hand_skin", "Foot_skin"]
    assert names(score_threshold=0.2, most_regions=1) == ["Hand_skin"]
    assert names(score_threshold=0.95) == []


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((10, 10), np.uint8),
        np.zeros((10, 10, 4), np.uint8),
        np.zeros((10, 10, 3), np.float32),
        np.zeros((0, 10, 3), np.uint8),
    ],
    ids=["grey", "alpha", "float", "empty"],
)
def test_other_arrays_are_refused(write_model, picture):
    with pytest.raises(PictureError, match="takes uint8 pictures of shape"):
        load(write_model([HAND])).detect(picture)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        pytest.param(
            {"classes": json.dumps(["cat", "dog"])}, r"its classes are \['cat', 'dog'\]", id="classes"
        ),
        pytest.param({"classes": json.dumps(list(SKIN_CLASSES[::-1]))}, "its classes are", id="order"),
        pytest.param({"classes": "no json"}, "its classes are no json", id="no json"),
        pytest.param({"task": "faces"}, "its task is 'faces'", id="task"),
        pytest.param({"size": "100"}, "input size is '100'", id="size"),
        pytest.param({"shape": (1, 1, 64, 64)}, "expected input", id="grey model"),
        pytest.param({"rows": [[0.0] * 85]}, "expected input", id="other output"),
    ],
)
def test_other_models_are_refused_on_one_line(write_model, change, reason):
    path = write_model(**{"rows": [HAND], **change})
    with pytest.raises(ModelError, match=reason) as caught:
        load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_are_no_models_are_refused(tmp_path):
    with pytest.raises(ModelError, match="there is no model file"):
        load(tmp_path / "none.onnx")
    (tmp_path / "text.onnx").write_text("no model")
    with pytest.raises(ModelError, match=r"cannot load .*text\.onnx as an ONNX model") as caught:
        load(tmp_path / "text.onnx")
    assert "\n" not in str(caught.value)


def test_a_model_of_one_shape_is_used_as_it_is(write_model):
    model = write_model([HAND], shape=(1, 3, 32, 64))
    assert load(model).size == 64
    assert load(model).detect(np.zeros((64, 128, 3), np.uint8))[0].box == pytest.approx(
        (48.0, 40.0, 80.0, 56.0)
    )
    with pytest.raises(ModelError, match="takes 64x32 px only"):
        load(model, SkinDetectorSettings(size=416))


def test_a_missing_provider_is_named_not_replaced(write_model):
    with pytest.raises(ModelError, match="has no TensorrtExecutionProvider"):
        load(write_model([HAND]), SkinDetectorSettings(provider="tensorrt"))


@pytest.mark.parametrize(
    "values",
    [{"size": 100}, {"threads": 0}, {"score_threshold": 1.5}, {"provider": "gpu"}, {"most_regions": 0}],
    ids=lambda values: next(iter(values)),
)
def test_senseless_settings_are_refused(values):
    with pytest.raises(SettingsError, match=next(iter(values))):
        SkinDetectorSettings(**values)


def test_the_models_face_is_where_the_astronauts_face_is():
    picture = astronaut()
    faces = [
        r for r in load(settings=SkinDetectorSettings(threads=1)).detect(picture) if r.name == "Face_skin"
    ]
    assert faces
    face = np.array(faces[0].box)
    assert overlap(face, ASTRONAUT_FACE)[0, 0] > 0.4
    assert area(face) < 3 * area(ASTRONAUT_FACE)


def test_a_black_picture_has_no_skin():
    assert load(settings=SkinDetectorSettings(threads=1)).detect(np.zeros((480, 848, 3), np.uint8)) == []


def test_the_default_model_fits_a_repository():
    from bathbot_perception.detection.detector import DEFAULT_MODEL

    assert DEFAULT_MODEL.stat().st_size < 15e6
