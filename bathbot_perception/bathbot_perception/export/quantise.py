"""An INT8 copy: `python -m bathbot_perception.export.quantise MODEL.onnx DATASET --out INT8.onnx`.

Static quantisation with the ranges that real pictures cause. The three heads' convolutions and the decoding
behind them stay in float32: pixels and scores in one tensor of 8 bits would lose both. The first convolution
is written as two, see `model_graph.split_stem`; the input are pixels, see `model_graph.take_pixels`.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import helper
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)
from onnxruntime.quantization.shape_inference import quant_pre_process

from bathbot_perception.detection.detector import load
from bathbot_perception.detection.letterbox import fit_input, letterbox
from bathbot_perception.errors import PerceptionError
from bathbot_perception.export.model_graph import decoding, full_weights, split_stem, take_pixels
from bathbot_perception.pictures.pictures import read_picture
from bathbot_perception.pictures.splits import split_samples

PICTURES = 160
"""Training pictures that set the ranges."""


class Pictures(CalibrationDataReader):
    """Pictures as the network gets them."""

    def __init__(self, files: Sequence[Path], name: str, size: int) -> None:
        """Read `files` one by one for the input `name`, the longer side of it `size` [px]."""
        self._inputs = self._read(files, name, size)

    def get_next(self) -> dict[str, NDArray[np.float32]] | None:
        """The next input; None after the last."""
        return next(self._inputs, None)

    @staticmethod
    def _read(files: Sequence[Path], name: str, size: int) -> Iterator[dict[str, NDArray[np.float32]]]:
        for file in files:
            rgb = read_picture(file).rgb
            yield {name: letterbox(rgb, fit_input(rgb.shape[:2], size))}


def quantise(model: Path, pictures: Sequence[Path], out: Path) -> None:
    """Write an INT8 copy of a float model.

    Args:
        model: ONNX file of `export.export`.
        pictures: That set the ranges.
        out: ONNX file to write.

    Raises:
        ModelError: On a model that is none of ours.
        PictureError: On a picture that cannot be read.
    """
    size = load(model).size
    whole = split_stem(full_weights(onnx.load(model)))
    metadata = {item.key: item.value for item in whole.metadata_props}
    with tempfile.TemporaryDirectory() as folder:
        float_file, prepared, made = (
            Path(folder) / name for name in ("float.onnx", "ready.onnx", "int8.onnx")
        )
        onnx.save(whole, float_file)
        quant_pre_process(str(float_file), str(prepared), skip_symbolic_shape=True)
        graph = onnx.load(prepared).graph
        quantize_static(
            str(prepared),
            str(made),
            Pictures(pictures, graph.input[0].name, size),
            quant_format=QuantFormat.QDQ,
            per_channel=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            calibrate_method=CalibrationMethod.MinMax,
            nodes_to_exclude=decoding(graph),
        )
        result = take_pixels(onnx.load(made))
    helper.set_model_props(result, metadata | {"precision": "int8"})
    out.parent.mkdir(parents=True, exist_ok=True)
    onnx.save(result, out)
    load(out)


def main() -> None:
    """Read the command line and quantise."""
    parser = argparse.ArgumentParser(description="Write an INT8 copy of a skin detector.")
    parser.add_argument("model", type=Path)
    parser.add_argument("dataset", type=Path, help="PASCAL VOC folder; its training pictures set the ranges")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    try:
        files = [sample.picture for sample in split_samples(given.dataset).train][:PICTURES]
        quantise(given.model, files, given.out)
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error
    print(f"{given.out}: {given.out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
