"""The graph of a model file: what must be known of it, and changes that keep its numbers."""

import numpy as np
import onnx
from onnx import helper, numpy_helper

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import ModelError

_HEAD = 3 * (5 + len(SKIN_CLASSES))  # channels of a head


def full_weights(model: onnx.ModelProto) -> onnx.ModelProto:
    """Undo `export.half_weights`: constants of float32 where the graph cast them."""
    stored = {item.name: item for item in model.graph.initializer}
    nodes = []
    for node in model.graph.node:
        if node.op_type == "Cast" and node.input[0] in stored and node.output[0] not in stored:
            values = numpy_helper.to_array(stored.pop(node.input[0])).astype(np.float32)
            stored[node.output[0]] = numpy_helper.from_array(values, node.output[0])
        else:
            nodes.append(node)
    del model.graph.initializer[:], model.graph.node[:]
    model.graph.initializer.extend(stored.values())
    model.graph.node.extend(nodes)
    return model


def split_stem(model: onnx.ModelProto) -> onnx.ModelProto:
    """Write the 6x6 convolution of the stem, stride 2, as one that gathers 2x2 pixels and a 3x3 one.

    The numbers stay the same. In INT8 a convolution copies three neighbouring bytes at a time for three
    channels, and took a seventh of the time of a picture; with twelve channels it copies twelve.

    Raises:
        ModelError: When the model does not begin with that convolution.
    """
    graph, shown = model.graph, model.graph.input[0].name
    stem = next((node for node in graph.node if node.op_type == "Conv" and node.input[0] == shown), None)
    stored = {item.name: item for item in graph.initializer}
    weights = numpy_helper.to_array(stored[stem.input[1]]) if stem is not None else np.zeros(0)
    if weights.shape[1:] != (3, 6, 6):
        raise ModelError("the model does not begin with a 6x6 convolution; was it exported by bathbot?")
    gathering = np.eye(12, dtype=np.float32).reshape(12, 3, 2, 2)
    channels = len(weights)
    merging = weights.reshape(channels, 3, 3, 2, 3, 2).transpose(0, 1, 3, 5, 2, 4).reshape(channels, 12, 3, 3)
    graph.initializer.remove(stored[stem.input[1]])
    graph.initializer.extend(
        numpy_helper.from_array(np.ascontiguousarray(values, dtype=np.float32), name)
        for name, values in (("stem.gathering", gathering), ("stem.merging", merging))
    )
    gather = helper.make_node(
        "Conv",
        [shown, "stem.gathering"],
        ["stem.gathered"],
        "stem.gather",
        kernel_shape=[2, 2],
        strides=[2, 2],
    )
    merge = helper.make_node(
        "Conv", ["stem.gathered", "stem.merging", *stem.input[2:]], list(stem.output), stem.name,
        kernel_shape=[3, 3], pads=[1, 1, 1, 1],
    )  # fmt: skip
    index = list(graph.node).index(stem)
    graph.node.remove(stem)
    graph.node.insert(index, merge)
    graph.node.insert(index, gather)
    return model


def take_pixels(model: onnx.ModelProto) -> onnx.ModelProto:
    """Let an INT8 model take pixels 0..255 where it made such integers of values 0..1 before.

    A picture needs a quarter of the memory then, and nobody turns it into floats only to round them again.

    Raises:
        ModelError: When the model does not begin with a quantisation.
    """
    graph, shown = model.graph, model.graph.input[0]
    first = [node for node in graph.node if shown.name in node.input]
    if [node.op_type for node in first] != ["QuantizeLinear"]:
        raise ModelError("the model does not begin with a quantisation of its input; is it INT8?")
    scale, zero = first[0].input[1:]
    for item in graph.initializer:
        if item.name == scale:
            item.CopyFrom(numpy_helper.from_array(np.array(1.0 / 255.0, np.float32), scale))
        elif item.name == zero:
            item.CopyFrom(numpy_helper.from_array(np.array(0, np.uint8), zero))
    for node in graph.node:
        for index, name in enumerate(node.input):
            if name == first[0].output[0]:
                node.input[index] = shown.name
    graph.node.remove(first[0])
    shown.type.tensor_type.elem_type = onnx.TensorProto.UINT8
    return model


def decoding(graph: onnx.GraphProto) -> list[str]:
    """Names of the heads' convolutions and of every node behind them.

    Raises:
        ModelError: When the graph has no such heads.
    """
    shapes = {item.name: tuple(item.dims) for item in graph.initializer}
    reached: set[str] = set()
    names = []
    for node in graph.node:
        head = node.op_type == "Conv" and shapes.get(node.input[1], (0,))[0] == _HEAD
        if head or reached.intersection(node.input):
            names.append(node.name)
            reached.update(node.output)
    if not names:
        raise ModelError(f"the model has no head with {_HEAD} channels; was it exported by bathbot?")
    return names
