"""Other forms of a model: `bathbot export detector`, for runtimes that want a fixed shape or float16."""

import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import onnx
import onnxruntime
from onnx import helper
from onnxruntime.tools.onnx_model_utils import fix_output_shapes, make_input_shape_fixed
from onnxruntime.transformers.float16 import convert_float_to_float16
from onnxruntime.transformers.onnx_model import OnnxModel

from bathbot_perception.detection.detector import load
from bathbot_perception.detection.letterbox import STRIDE
from bathbot_perception.errors import ModelError, SettingsError
from bathbot_perception.export.model_graph import full_weights
from bathbot_perception.export.quantise import quantise

_OPSET = 13  # the newest that TensorRT 8.2 reads


class Converted(NamedTuple):
    """A file that was written.

    Attributes:
        size_mb: Of the file.
        opset: Of ONNX.
        shape: Height and width of the input [px]; None: any multiple of 32.
        difference: Largest one of any predicted box [px] or score to the model it came from, on noise.
    """

    size_mb: float
    opset: int
    shape: tuple[int, int] | None
    difference: float


def convert(
    model: Path,
    out: Path,
    precision: str,
    shape: tuple[int, int] | None = None,
    pictures: Sequence[Path] = (),
) -> Converted:
    """Write a model in another precision, or for one shape of input.

    Args:
        model: ONNX file of ours, not INT8.
        out: File to write.
        precision: A key of `PRECISIONS`.
        shape: Height and width [px], if the file shall take one shape only, as TensorRT is fastest with.
        pictures: That set the ranges of int8.

    Raises:
        ModelError: On a model that is none of ours or was quantised.
        SettingsError: On an unknown precision, a shape of no multiples of 32, or int8 without pictures.
    """
    if precision not in PRECISIONS:
        raise SettingsError(f"precision must be one of {', '.join(PRECISIONS)}, got {precision!r}")
    if shape and (min(shape) < STRIDE or any(side % STRIDE for side in shape)):
        raise SettingsError(f"both sides of the input must be multiples of {STRIDE} px, got {shape}")
    load(model)
    source = onnx.load(model)
    metadata = {item.key: item.value for item in source.metadata_props}
    if metadata.get("precision") == "int8":
        raise ModelError(f"{model} is INT8 already; export from the float model it was made of")
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder) / "base.onnx"
        onnx.save(source, base)
        made = PRECISIONS[precision](base, pictures)
    if shape:
        made = fixed(made, shape)
        metadata["size"] = str(max(shape))
    helper.set_model_props(made, metadata | {"precision": precision})
    onnx.checker.check_model(made)
    out.parent.mkdir(parents=True, exist_ok=True)
    onnx.save(made, out)
    opset = next(item.version for item in made.opset_import if item.domain in ("", "ai.onnx"))
    return Converted(out.stat().st_size / 1e6, opset, shape, largest_difference(model, out, shape))


def fixed(model: onnx.ModelProto, shape: tuple[int, int]) -> onnx.ModelProto:
    """The model for one height and width [px], everything that follows from them computed beforehand."""
    make_input_shape_fixed(model.graph, model.graph.input[0].name, [1, 3, *shape])
    fix_output_shapes(model)
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
    options.log_severity_level = 4
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "folded.onnx"
        options.optimized_model_filepath = str(file)
        onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
        return onnx.load(file)


def largest_difference(first: Path, second: Path, shape: tuple[int, int] | None) -> float:
    """Of two models' predictions [px or score] on noise."""
    noise = np.random.default_rng(0).integers(0, 256, (1, 3, *(shape or (320, 416))), dtype=np.uint8)
    ours, theirs = (load(file).predict(noise) for file in (first, second))
    return float(np.abs(ours - theirs).max())


def _float32(model: Path, pictures: Sequence[Path]) -> onnx.ModelProto:
    return full_weights(onnx.load(model))


def _float16(model: Path, pictures: Sequence[Path]) -> onnx.ModelProto:
    half = OnnxModel(convert_float_to_float16(full_weights(onnx.load(model)), keep_io_types=True))
    half.topological_sort()  # the conversion puts casts behind their first use
    return half.model


def _int8(model: Path, pictures: Sequence[Path]) -> onnx.ModelProto:
    if not pictures:
        raise SettingsError("int8 needs pictures that set its ranges; name a data set")
    quantise(model, pictures, model.with_name("int8.onnx"))
    return onnx.load(model.with_name("int8.onnx"))


PRECISIONS: Mapping[str, Callable[[Path, Sequence[Path]], onnx.ModelProto]] = MappingProxyType(
    {"fp32": _float32, "fp16": _float16, "int8": _int8}
)
