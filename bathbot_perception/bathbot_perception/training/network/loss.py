"""What the network is trained to minimise: box overlap, objectness and class.

A box belongs to an anchor whose sides differ from it by less than `RATIO_LIMIT` times, in the
cell of its centre and in the two neighbours nearest to the centre. Box loss is 1 - CIoU
(Zheng et al. 2020); objectness is trained towards the overlap reached; both it and the class
use binary cross entropy.
"""

import math
from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits as cross_entropy

from bathbot_perception.training.network.network import STRIDES

RATIO_LIMIT = 4.0
OBJECTNESS_BALANCE = (4.0, 1.0, 0.4)
"""Weights of the fine, middle and coarse head: small objects fill a smaller share of their cells."""
BOX_GAIN, OBJECTNESS_GAIN, CLASS_GAIN = 0.05, 0.6, 0.06


class LossParts(NamedTuple):
    """Weighted parts of the loss; their sum is minimised."""

    box: Tensor
    objectness: Tensor
    category: Tensor

    @property
    def total(self) -> Tensor:
        """The sum."""
        return self.box + self.objectness + self.category


class Matches(NamedTuple):
    """Cells and anchors of one head that answer for a box, n of them."""

    batch: Tensor
    anchor: Tensor
    row: Tensor
    column: Tensor
    box: Tensor
    """Centre and size in cells, shape (n, 4)."""
    category: Tensor


def match(targets: Tensor, anchors: Tensor, rows: int, columns: int) -> Matches:
    """Choose cells and anchors of one head for the targets.

    Args:
        targets: (picture in batch, class, centre u, centre v, width, height) in cells, shape (n, 6).
        anchors: Anchor sizes in cells, shape (3, 2).
        rows: Height of the head's grid.
        columns: Width of the head's grid.

    Returns:
        Matches; a target may occur up to nine times or not at all.
    """
    ratio = targets[None, :, 4:6] / anchors[:, None, :]
    fits = torch.maximum(ratio, 1.0 / ratio).amax(dim=-1) < RATIO_LIMIT
    anchor, index = fits.nonzero(as_tuple=True)
    chosen = targets[index]
    centre, size = chosen[:, 2:4], torch.tensor([columns, rows])
    offsets = torch.tensor([[0, 0], [-1, 0], [0, -1], [1, 0], [0, 1]])
    inside = centre - centre.floor()
    below, above = (inside < 0.5) & (centre > 1.0), (inside > 0.5) & (centre < size - 1.0)
    use = torch.cat([torch.ones(len(chosen), 1, dtype=torch.bool), below, above], dim=1)
    item, neighbour = use.nonzero(as_tuple=True)
    cell = (centre[item].floor().long() + offsets[neighbour]).clamp(min=0)
    cell = torch.minimum(cell, size - 1)
    chosen = chosen[item]
    box = torch.cat([chosen[:, 2:4] - cell, chosen[:, 4:6]], dim=1)
    return Matches(chosen[:, 0].long(), anchor[item], cell[:, 1], cell[:, 0], box, chosen[:, 1].long())


def complete_overlap(first: Tensor, second: Tensor) -> Tensor:
    """CIoU of paired boxes (centre, size), shapes (n, 4): overlap less distance less shape."""
    low = torch.maximum(first[:, :2] - first[:, 2:] / 2, second[:, :2] - second[:, 2:] / 2)
    high = torch.minimum(first[:, :2] + first[:, 2:] / 2, second[:, :2] + second[:, 2:] / 2)
    shared = (high - low).clamp(min=0).prod(dim=1)
    union = first[:, 2:].prod(dim=1) + second[:, 2:].prod(dim=1) - shared
    plain = shared / (union + 1e-7)
    outer_low = torch.minimum(first[:, :2] - first[:, 2:] / 2, second[:, :2] - second[:, 2:] / 2)
    outer_high = torch.maximum(first[:, :2] + first[:, 2:] / 2, second[:, :2] + second[:, 2:] / 2)
    diagonal = (outer_high - outer_low).square().sum(dim=1) + 1e-7
    distance = (first[:, :2] - second[:, :2]).square().sum(dim=1) / diagonal
    slant = torch.atan(first[:, 2] / (first[:, 3] + 1e-7)) - torch.atan(second[:, 2] / (second[:, 3] + 1e-7))
    shape = 4.0 / math.pi**2 * slant.square()
    with torch.no_grad():
        weight = shape / (shape - plain + 1.0 + 1e-7)
    return plain - distance - weight * shape


def detection_loss(raw: list[Tensor], targets: Tensor, anchors: Tensor) -> LossParts:
    """Loss of one batch.

    Args:
        raw: Head outputs, see `network.Yolov5s.forward`.
        targets: (picture in batch, class, centre u, centre v, width, height [px]), shape (n, 6).
        anchors: Anchor sizes [px], shape (3, 3, 2).

    Returns:
        The three parts.
    """
    zero = torch.zeros(())
    box_loss, objectness_loss, class_loss = zero, zero, zero
    for output, head_anchors, stride, balance in zip(raw, anchors, STRIDES, OBJECTNESS_BALANCE, strict=True):
        output = output.float()
        scaled = targets.clone()
        scaled[:, 2:] /= stride
        found = match(scaled, head_anchors / stride, output.shape[2], output.shape[3])
        wanted = torch.zeros(output.shape[:-1])
        if len(found.batch):
            answer = output[found.batch, found.anchor, found.row, found.column]
            chance = answer[:, :4].sigmoid()
            size = (chance[:, 2:] * 2.0) ** 2 * (head_anchors / stride)[found.anchor]
            reached = complete_overlap(torch.cat([chance[:, :2] * 2.0 - 0.5, size], dim=1), found.box)
            box_loss = box_loss + (1.0 - reached).mean()
            wanted[found.batch, found.anchor, found.row, found.column] = reached.detach().clamp(min=0)
            one_hot = torch.zeros_like(answer[:, 5:])
            one_hot[torch.arange(len(one_hot)), found.category] = 1.0
            class_loss = class_loss + cross_entropy(answer[:, 5:], one_hot)
        objectness_loss = objectness_loss + balance * cross_entropy(output[..., 4], wanted)
    return LossParts(BOX_GAIN * box_loss, OBJECTNESS_GAIN * objectness_loss, CLASS_GAIN * class_loss)
