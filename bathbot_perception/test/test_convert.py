"""Other forms of the shipped model."""

import numpy as np
import onnx
import pytest
from bathbot_perception.detection.detector import DEFAULT_MODEL, MODELS, load
from bathbot_perception.errors import ModelError, SettingsError
from bathbot_perception.export.convert import PRECISIONS, convert
from onnx import TensorProto


def test_float32_is_the_same_function(tmp_path):
    made = convert(DEFAULT_MODEL, tmp_path / "new" / "model.onnx", "fp32")
    assert made.difference < 2e-3
    assert made.shape is None


def test_a_fixed_float16_model_is_what_tensorrt_8_reads(tmp_path):
    out = tmp_path / "model.onnx"
    made = convert(DEFAULT_MODEL, out, "fp16", (96, 128))
    model = onnx.load(out)
    assert (made.opset, made.shape) == (13, (96, 128))
    assert {node.domain for node in model.graph.node} <= {"", "ai.onnx"}
    assert not {"Shape", "Range", "NonZero", "Loop", "If"} & {node.op_type for node in model.graph.node}
    assert sum(item.data_type == TensorProto.FLOAT16 for item in model.graph.initializer) > 100
    assert made.size_mb < 16
    rgb = np.random.default_rng(0).integers(0, 256, (90, 120, 3), dtype=np.uint8)
    assert load(out).fit(rgb.shape[:2]).width == 128
    assert isinstance(load(out).detect(rgb), list)
    assert made.difference < 5.0


def test_int8_needs_pictures_and_is_not_quantised_twice(tmp_path):
    with pytest.raises(SettingsError, match="needs pictures"):
        convert(DEFAULT_MODEL, tmp_path / "a.onnx", "int8")
    with pytest.raises(ModelError, match="INT8 already"):
        convert(MODELS / "skin_int8.onnx", tmp_path / "b.onnx", "fp16")


@pytest.mark.parametrize(("precision", "shape"), [("fp8", None), ("fp32", (100, 128)), ("fp32", (0, 128))])
def test_what_cannot_be_made_is_said(tmp_path, precision, shape):
    with pytest.raises(SettingsError, match="must be"):
        convert(DEFAULT_MODEL, tmp_path / "a.onnx", precision, shape)
    assert not (tmp_path / "a.onnx").exists()
    assert set(PRECISIONS) == {"fp32", "fp16", "int8"}
