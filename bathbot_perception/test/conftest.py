"""Tiny ONNX models whose answer is known."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import onnx
import pytest
from bathbot_perception.classes import SKIN_CLASSES
from hypothesis import settings
from onnx import TensorProto, helper, numpy_helper

settings.register_profile("shared machine", deadline=None)
settings.load_profile("shared machine")


@pytest.fixture
def write_model(tmp_path) -> Callable[..., Path]:
    """Write a model that answers every picture with the same predictions."""

    def write(
        rows: list[list[float]],
        name: str = "tiny.onnx",
        shape: tuple[int | str, ...] = (1, 3, "height", "width"),
        **metadata: str,
    ) -> Path:
        values = np.array([rows], dtype=np.float32)
        constant = helper.make_node("Constant", [], ["predictions"], value=numpy_helper.from_array(values))
        graph = helper.make_graph(
            [constant],
            "tiny",
            [helper.make_tensor_value_info("images", TensorProto.FLOAT, shape)],
            [helper.make_tensor_value_info("predictions", TensorProto.FLOAT, values.shape)],
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
        defaults = {"task": "skin-regions", "classes": json.dumps(list(SKIN_CLASSES)), "size": "64"}
        helper.set_model_props(model, {**defaults, **metadata})
        path = tmp_path / name
        onnx.save(model, path)
        return path

    return write
