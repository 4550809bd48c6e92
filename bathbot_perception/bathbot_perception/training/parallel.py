"""One step's gradient from several threads that meet once a step.

Torch's own threads meet after every layer; when another program holds a core, each meeting waits
for the scheduler. Here each thread takes a part of the batch through a replica of the network by
itself. Replicas share the weights and have gradients of their own; running means of the norms are
kept by the first.
"""

import copy
from concurrent.futures import ThreadPoolExecutor

import torch

from bathbot_perception.training.data.batches import Batch
from bathbot_perception.training.network.loss import detection_loss
from bathbot_perception.training.network.network import Yolov5s

Losses = tuple[float, float, float]


class ParallelGradient:
    """Computes gradients of a network; use one thread per core."""

    def __init__(self, model: Yolov5s, threads: int) -> None:
        """Make `threads` - 1 replicas of `model`; torch's own threads are set to one."""
        torch.set_num_threads(1)
        self._replicas = [model, *(copy.deepcopy(model) for _ in range(threads - 1))]
        for replica in self._replicas[1:]:
            for ours, theirs in zip(replica.parameters(), model.parameters(), strict=True):
                ours.data = theirs.data
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="gradient")

    def compute(self, batch: Batch, frozen_backbone: bool = False) -> Losses:
        """Fill `grad` of the network's parameters; returns the parts of the loss, each a mean."""
        for replica in self._replicas:
            replica.train().backbone.requires_grad_(not frozen_backbone)
        parts = split_batch(batch, len(self._replicas))
        replicas = self._replicas[: len(parts)]
        losses = list(self._pool.map(_backward, replicas, parts))
        for own, *others in zip(*(replica.parameters() for replica in replicas), strict=True):
            for other in others:
                if other.grad is not None:
                    own.grad.add_(other.grad)
                    other.grad = None
            if own.grad is not None:
                own.grad.div_(len(parts))
        return tuple(sum(values) / len(losses) for values in zip(*losses, strict=True))

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()


def split_batch(batch: Batch, count: int) -> list[Batch]:
    """Parts of a batch with nearly equal numbers of pictures, at most `count`, none empty."""
    parts, start = [], 0
    for pictures in torch.tensor_split(batch.pictures, min(count, len(batch.pictures))):
        end = start + len(pictures)
        inside = (batch.targets[:, 0] >= start) & (batch.targets[:, 0] < end)
        targets = batch.targets[inside].clone()
        targets[:, 0] -= start
        parts.append(Batch(pictures, targets))
        start = end
    return parts


def _backward(replica: Yolov5s, part: Batch) -> Losses:
    with torch.autocast("cpu", torch.bfloat16):
        raw = replica(part.pictures.contiguous(memory_format=torch.channels_last))
    losses = detection_loss(raw, part.targets, replica.anchors)
    losses.total.backward()
    return float(losses.box.detach()), float(losses.objectness.detach()), float(losses.category.detach())
