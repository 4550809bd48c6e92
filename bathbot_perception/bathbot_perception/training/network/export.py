"""From a checkpoint to an ONNX model.

    python -m bathbot_perception.training.network.export CHECKPOINT MODEL.onnx

The model takes RGB in [0, 1], shape (1, 3, h, w), h and w multiples of 32, and gives decoded
predictions (1, N, 5 + classes), see `network.decode`. Class names, input size and task are in
its metadata. Weights are stored as float16 and cast to float32 when the model is loaded: half
the file, the same speed.
"""

import argparse
import io
import json
import warnings
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import ModelError, PerceptionError
from bathbot_perception.training.network.checkpoint import averaged_network, read_state
from bathbot_perception.training.network.network import ConvBlock, Yolov5s, predictions

OPSET = 13
LARGE = 256
"""Constants with more elements than this are stored as float16."""


class Exported(nn.Module):
    """The network with its decoding, as one function of a picture."""

    def __init__(self, model: Yolov5s) -> None:
        """Fold the batch norms into the convolutions."""
        super().__init__()
        self.model = model.eval()
        for module in self.model.modules():
            if isinstance(module, ConvBlock):
                module.convolution = fuse_conv_bn_eval(module.convolution, module.norm)
                module.norm = nn.Identity()

    def forward(self, picture: Tensor) -> Tensor:
        """Decoded predictions, shape (1, N, 5 + classes)."""
        return predictions(self.model, picture)


def export(
    checkpoint: Path, path: Path, size: int | None = None, shape: tuple[int, int] | None = None
) -> None:
    """Write the averaged network of a checkpoint as ONNX and compare the two.

    Args:
        checkpoint: File of `checkpoint.save_run`.
        path: ONNX file to write.
        size: Longer side of the input it is meant for [px]; without it that of the training.
        shape: Height and width, if the model shall take one shape only (TensorRT).

    Raises:
        ModelError: If the written model gives other numbers than the network.
    """
    state = read_state(checkpoint)
    module, size = Exported(averaged_network(state)), size or state["size"]
    model = half_weights(trace(module, shape or (size, size), fixed=shape is not None))
    add_metadata(model, size)
    onnx.checker.check_model(model)
    path.parent.mkdir(parents=True, exist_ok=True)
    onnx.save(model, path)
    shapes = [shape] if shape else [(size, size), (320, 416), (416, 288)]
    worst = max(largest_difference(module, path, item) for item in shapes)
    if worst > 1.0:
        raise ModelError(f"{path} differs from the network by {worst:.2f} px or in score; do not use it")
    print(f"{path}: {path.stat().st_size / 1e6:.2f} MB, largest difference to the network {worst:.4f}")


def trace(module: Exported, shape: tuple[int, int], fixed: bool) -> onnx.ModelProto:
    """The module as an ONNX graph; height and width stay open unless `fixed`."""
    buffer = io.BytesIO()
    axes = {} if fixed else {"images": {2: "height", 3: "width"}, "predictions": {1: "count"}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            module,
            (torch.rand(1, 3, *shape),),
            buffer,
            opset_version=OPSET,
            dynamo=False,
            input_names=["images"],
            output_names=["predictions"],
            dynamic_axes=axes,
        )
    model = onnx.load_from_string(buffer.getvalue())
    dimensions = model.graph.output[0].type.tensor_type.shape.dim
    dimensions[0].dim_value, dimensions[2].dim_value = 1, 5 + len(SKIN_CLASSES)  # the tracer loses them
    return model


def half_weights(model: onnx.ModelProto) -> onnx.ModelProto:
    """Store large float32 constants as float16 and cast them back in the graph."""
    casts, stored = [], []
    for initialiser in model.graph.initializer:
        values = numpy_helper.to_array(initialiser)
        if initialiser.data_type == TensorProto.FLOAT and values.size > LARGE:
            name = f"{initialiser.name}.half"
            casts.append(helper.make_node("Cast", [name], [initialiser.name], to=TensorProto.FLOAT))
            stored.append(numpy_helper.from_array(values.astype(np.float16), name))
        else:
            stored.append(initialiser)
    nodes = [*casts, *model.graph.node]
    del model.graph.initializer[:], model.graph.node[:]
    model.graph.initializer.extend(stored)
    model.graph.node.extend(nodes)
    return model


def add_metadata(model: onnx.ModelProto, size: int) -> None:
    """Say in the file what it is; the runtime refuses a model that does not."""
    values = {
        "task": "skin-regions",
        "classes": json.dumps(list(SKIN_CLASSES)),
        "size": str(size),
        "network": "yolov5s",
    }
    helper.set_model_props(model, values)
    model.producer_name = "bathbot_perception"


def largest_difference(module: Exported, path: Path, shape: tuple[int, int]) -> float:
    """Largest absolute difference [px or score] of the written model to the network on noise."""
    import onnxruntime

    picture = torch.rand(1, 3, *shape, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        ours = module(picture).numpy()
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    return float(np.abs(session.run(None, {"images": picture.numpy()})[0] - ours).max())


def main() -> None:
    """Read the command line and export."""
    parser = argparse.ArgumentParser(description="Write a trained skin detector as ONNX.")
    parser.add_argument("checkpoint", type=Path)
    parser.add_argument("model", type=Path)
    parser.add_argument("--size", type=int, help="longer side of the input [px]; else as in training")
    parser.add_argument("--shape", type=int, nargs=2, metavar=("HEIGHT", "WIDTH"), help="fix the input shape")
    arguments = parser.parse_args()
    try:
        export(
            arguments.checkpoint,
            arguments.model,
            arguments.size,
            tuple(arguments.shape) if arguments.shape else None,
        )
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
