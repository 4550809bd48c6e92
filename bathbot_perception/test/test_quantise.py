"""INT8 copies of the shipped model."""

import cv2
import numpy as np
import onnx
import pytest
from bathbot_perception.detection.detector import DEFAULT_MODEL, MODELS, load
from bathbot_perception.detection.letterbox import Letterboxing, fit_input
from bathbot_perception.errors import ModelError
from bathbot_perception.export.convert import convert
from bathbot_perception.export.model_graph import decoding, full_weights, split_stem, take_pixels
from onnx import TensorProto


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    folder, random = tmp_path_factory.mktemp("pictures"), np.random.default_rng(0)
    for index in range(3):
        picture = cv2.resize(random.integers(0, 256, (12, 16, 3), dtype=np.uint8), (320, 240))
        cv2.imwrite(str(folder / f"{index}.png"), picture)
    return sorted(folder.iterdir())


@pytest.mark.parametrize("change", [full_weights, lambda model: split_stem(full_weights(model))])
def test_changes_of_the_graph_keep_its_numbers(tmp_path, change):
    changed = change(onnx.load(DEFAULT_MODEL))
    assert not [item.name for item in changed.graph.initializer if item.data_type == TensorProto.FLOAT16]
    onnx.save(changed, tmp_path / "changed.onnx")
    pixels = np.random.default_rng(1).integers(0, 256, (1, 3, 96, 128), dtype=np.uint8)
    ours, theirs = (load(file).predict(pixels) for file in (DEFAULT_MODEL, tmp_path / "changed.onnx"))
    np.testing.assert_allclose(ours, theirs, atol=2e-3)


def test_a_model_with_another_stem_is_refused(write_model):
    with pytest.raises(ModelError, match="does not begin"):
        split_stem(onnx.load(write_model([[0.0] * 11])))


def test_the_heads_and_what_follows_stay_float():
    graph = full_weights(onnx.load(DEFAULT_MODEL)).graph
    names = set(decoding(graph))
    heads = [node for node in graph.node if node.name in names and node.op_type == "Conv"]
    assert len(heads) == 3
    assert graph.output[0].name in {out for node in graph.node if node.name in names for out in node.output}


def test_a_quantised_model_is_small_and_still_a_skin_detector(tmp_path, pictures):
    out = tmp_path / "new" / "int8.onnx"
    convert(DEFAULT_MODEL, out, "int8", pictures=pictures)
    assert out.stat().st_size < 8e6
    detector = load(out)
    assert detector.size == load(DEFAULT_MODEL).size
    predictions = detector.predict(np.full((1, 3, 96, 128), 90, np.uint8))
    assert predictions.shape[1] == 11
    assert np.isfinite(predictions).all()


def test_the_shipped_copy_takes_pixels_and_says_nearly_what_the_float_model_says(pictures):
    picture = cv2.imread(str(pictures[0]))
    int8 = onnx.load(MODELS / "skin_int8.onnx")
    assert int8.graph.input[0].type.tensor_type.elem_type == TensorProto.UINT8
    pixels = Letterboxing(picture.shape[:2], fit_input(picture.shape[:2], 320))(picture)
    ours, theirs = (load(MODELS / name).predict(pixels) for name in ("skin.onnx", "skin_int8.onnx"))
    assert ours.shape == theirs.shape
    assert np.abs(ours - theirs)[:, 4:].mean() < 0.02


def test_only_a_model_that_rounds_its_input_can_take_pixels():
    with pytest.raises(ModelError, match="is it INT8"):
        take_pixels(onnx.load(DEFAULT_MODEL))
    with pytest.raises(ModelError, match="is it INT8"):
        take_pixels(onnx.load(MODELS / "skin_int8.onnx"))


def test_a_model_without_heads_is_refused(write_model):
    with pytest.raises(ModelError, match="no head"):
        decoding(onnx.load(write_model([[0.0] * 11])).graph)
