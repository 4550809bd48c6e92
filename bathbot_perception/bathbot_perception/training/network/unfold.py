"""A network that can learn on, from an ONNX file, where the batch norms are folded into the weights."""

from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import ModelError
from bathbot_perception.export.model_graph import full_weights
from bathbot_perception.training.network.network import ConvBlock, Yolov5s


def network_from_onnx(path: Path, pictures: Tensor) -> tuple[Yolov5s, int]:
    """The network of a float model that `export.export` wrote, with batch norms again; and its size [px].

    Args:
        path: ONNX file.
        pictures: Such as training will show, in [0, 1], shape (b, 3, h, w); the norms take their means and
            variances from these, so that the network gives the file's numbers and can learn at once.

    Raises:
        ModelError: If the file cannot be read or is not our network in float.
    """
    try:
        model = full_weights(onnx.load(path))
        size = int({item.key: item.value for item in model.metadata_props}["size"])
        stored = model.graph.initializer
        weights = {item.name.removeprefix("model."): _tensor(item) for item in stored}
        network = Yolov5s(len(SKIN_CLASSES), weights["anchors"])
        _fill(network, weights, pictures)
    except Exception as error:  # protobuf, onnx and torch raise unrelated types
        raise ModelError(
            f"cannot train on from {path}: {type(error).__name__} {error}; name a checkpoint, or a float "
            "model that `bathbot train detector` wrote"
        ) from error
    return network.train(), size


def _tensor(item: onnx.TensorProto) -> Tensor:
    return torch.from_numpy(np.array(numpy_helper.to_array(item)))


@torch.no_grad()
def _fill(network: Yolov5s, weights: dict[str, Tensor], pictures: Tensor) -> None:
    """Set all weights; a hook before each norm sees what it must undo."""
    hooks = []
    for name, block in network.named_modules():
        if isinstance(block, ConvBlock):
            block.convolution.weight.copy_(weights[f"{name}.convolution.weight"])
            undo = _Undo(weights[f"{name}.convolution.bias"])
            hooks.append(block.norm.register_forward_pre_hook(undo))
    for index, head in enumerate(network.heads):
        head.weight.copy_(weights[f"heads.{index}.weight"])
        head.bias.copy_(weights[f"heads.{index}.bias"])
    network.eval()(pictures)
    for hook in hooks:
        hook.remove()


class _Undo:
    """Gives a norm the statistics of its input, and the scale and shift that undo them and add a bias."""

    def __init__(self, bias: Tensor) -> None:
        self._bias = bias

    def __call__(self, norm: nn.BatchNorm2d, inputs: tuple[Tensor]) -> None:
        variance, mean = torch.var_mean(inputs[0].float(), dim=(0, 2, 3), correction=0)
        norm.running_mean.copy_(mean)
        norm.running_var.copy_(variance)
        norm.weight.copy_((variance + norm.eps).sqrt())
        norm.bias.copy_(mean + self._bias)
