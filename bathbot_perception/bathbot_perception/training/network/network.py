"""YOLOv5s: a CSP backbone, a PANet neck and three anchored heads (section 2.1.1).

Written from the published description: depth multiple 0.33, width multiple 0.5, about
7 million parameters. A head gives, per cell and anchor, four numbers of a box, one of
objectness and one per class. A box follows from sigmoids s of the four as

    centre = (2 s_xy - 0.5 + cell) stride,    size = (2 s_wh)^2 anchor    [px].
"""

import math

import torch
from torch import Tensor, nn

STRIDES: tuple[int, ...] = (8, 16, 32)
ANCHORS_PER_CELL = 3
WIDTHS: tuple[int, ...] = (32, 64, 128, 256, 512)
"""Channels of the five stages."""
DEPTHS: tuple[int, ...] = (1, 2, 3, 1)
"""Bottlenecks in the CSP blocks of stages 2 to 5."""


class ConvBlock(nn.Module):
    """Convolution, batch norm, ReLU.

    YOLOv5s has had LeakyReLU, Hardswish and SiLU here. ReLU is part of the convolution in INT8 and in
    TensorRT 8.2; SiLU would be two more operations after each, a third of the time of an INT8 picture.
    """

    def __init__(
        self, inputs: int, outputs: int, kernel: int = 1, stride: int = 1, padding: int | None = None
    ) -> None:
        """Pad so that an odd kernel at stride 1 keeps the size, unless `padding` says otherwise."""
        super().__init__()
        padding = kernel // 2 if padding is None else padding
        self.convolution = nn.Conv2d(inputs, outputs, kernel, stride, padding, bias=False)
        self.norm = nn.BatchNorm2d(outputs, eps=1e-3, momentum=0.03)
        self.activation = nn.ReLU(inplace=True)

    def forward(self, features: Tensor) -> Tensor:
        """Shape (b, inputs, h, w) -> (b, outputs, h / stride, w / stride)."""
        return self.activation(self.norm(self.convolution(features)))


class Bottleneck(nn.Module):
    """1x1 then 3x3 convolution, added to the input if `shortcut`."""

    def __init__(self, channels: int, shortcut: bool) -> None:
        """Keep the number of channels."""
        super().__init__()
        self.reduce = ConvBlock(channels, channels, 1)
        self.expand = ConvBlock(channels, channels, 3)
        self.shortcut = shortcut

    def forward(self, features: Tensor) -> Tensor:
        """Keep the shape."""
        result = self.expand(self.reduce(features))
        return features + result if self.shortcut else result


class CspBlock(nn.Module):
    """Cross stage partial block with three convolutions ("C3") round `depth` bottlenecks."""

    def __init__(self, inputs: int, outputs: int, depth: int = 1, shortcut: bool = True) -> None:
        """Run half of the channels through the bottlenecks, half past them."""
        super().__init__()
        hidden = outputs // 2
        self.enter = ConvBlock(inputs, hidden)
        self.bypass = ConvBlock(inputs, hidden)
        self.leave = ConvBlock(2 * hidden, outputs)
        self.bottlenecks = nn.Sequential(*(Bottleneck(hidden, shortcut) for _ in range(depth)))

    def forward(self, features: Tensor) -> Tensor:
        """Shape (b, inputs, h, w) -> (b, outputs, h, w)."""
        return self.leave(torch.cat([self.bottlenecks(self.enter(features)), self.bypass(features)], dim=1))


class PyramidPool(nn.Module):
    """Spatial pyramid pooling by one pool applied three times ("SPPF")."""

    def __init__(self, channels: int, kernel: int = 5) -> None:
        """Keep the number of channels."""
        super().__init__()
        self.enter = ConvBlock(channels, channels // 2)
        self.leave = ConvBlock(channels * 2, channels)
        self.pool = nn.MaxPool2d(kernel, stride=1, padding=kernel // 2)

    def forward(self, features: Tensor) -> Tensor:
        """Keep the shape."""
        once = self.enter(features)
        twice = self.pool(once)
        thrice = self.pool(twice)
        return self.leave(torch.cat([once, twice, thrice, self.pool(thrice)], dim=1))


class Backbone(nn.Module):
    """CSP-Darknet: features at strides 8, 16 and 32."""

    def __init__(self) -> None:
        """Build the five stages."""
        super().__init__()
        self.stem = ConvBlock(3, WIDTHS[0], kernel=6, stride=2, padding=2)
        self.stages = nn.ModuleList(
            nn.Sequential(ConvBlock(narrow, wide, 3, 2), CspBlock(wide, wide, depth))
            for narrow, wide, depth in zip(WIDTHS[:-1], WIDTHS[1:], DEPTHS, strict=True)
        )
        self.pyramid = PyramidPool(WIDTHS[-1])

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Shape (b, 3, H, W) -> features with 128, 256 and 512 channels."""
        features = self.stages[0](self.stem(picture))
        fine = self.stages[1](features)
        middle = self.stages[2](fine)
        return fine, middle, self.pyramid(self.stages[3](middle))


class Neck(nn.Module):
    """Path aggregation (PANet): coarse features down to fine ones and up again."""

    def __init__(self) -> None:
        """Build the two ways."""
        super().__init__()
        fine, middle, coarse = WIDTHS[2:]
        self.upsample = nn.Upsample(scale_factor=2, mode="nearest")
        self.narrow_coarse = ConvBlock(coarse, middle)
        self.merge_middle = CspBlock(2 * middle, middle, shortcut=False)
        self.narrow_middle = ConvBlock(middle, fine)
        self.merge_fine = CspBlock(2 * fine, fine, shortcut=False)
        self.shrink_fine = ConvBlock(fine, fine, 3, 2)
        self.leave_middle = CspBlock(2 * fine, middle, shortcut=False)
        self.shrink_middle = ConvBlock(middle, middle, 3, 2)
        self.leave_coarse = CspBlock(2 * middle, coarse, shortcut=False)

    def forward(self, fine: Tensor, middle: Tensor, coarse: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Keep the three shapes."""
        lateral_coarse = self.narrow_coarse(coarse)
        merged = self.merge_middle(torch.cat([self.upsample(lateral_coarse), middle], dim=1))
        lateral_middle = self.narrow_middle(merged)
        fine = self.merge_fine(torch.cat([self.upsample(lateral_middle), fine], dim=1))
        middle = self.leave_middle(torch.cat([self.shrink_fine(fine), lateral_middle], dim=1))
        return fine, middle, self.leave_coarse(torch.cat([self.shrink_middle(middle), lateral_coarse], dim=1))


class Yolov5s(nn.Module):
    """The whole detector; `anchors` [px], shape (3 heads, 3, 2), travel with the weights."""

    def __init__(self, classes: int, anchors: Tensor) -> None:
        """Start from weights that call almost every cell empty."""
        super().__init__()
        self.classes = classes
        self.backbone = Backbone()
        self.neck = Neck()
        self.heads = nn.ModuleList(
            nn.Conv2d(width, ANCHORS_PER_CELL * (5 + classes), 1) for width in WIDTHS[2:]
        )
        self.register_buffer("anchors", anchors.float().reshape(len(STRIDES), ANCHORS_PER_CELL, 2))
        for head, stride in zip(self.heads, STRIDES, strict=True):
            bias = head.bias.detach().view(ANCHORS_PER_CELL, -1)
            bias[:, 4] += math.log(8.0 / (416.0 / stride) ** 2)  # about 8 objects in a 416 px picture
            bias[:, 5:] += math.log(0.6 / (classes - 0.99))

    def forward(self, picture: Tensor) -> list[Tensor]:
        """Raw head outputs, shape (b, 3, H / stride, W / stride, 5 + classes), fine to coarse."""
        outputs = []
        for head, features in zip(self.heads, self.neck(*self.backbone(picture)), strict=True):
            raw = head(features)
            batch, _, rows, columns = raw.shape
            raw = raw.view(batch, ANCHORS_PER_CELL, 5 + self.classes, rows, columns)
            outputs.append(raw.permute(0, 1, 3, 4, 2))
        return outputs


def cells(rows: int, columns: int) -> Tensor:
    """Column and row of every cell, shape (1, 1, rows, columns, 2)."""
    row, column = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    return torch.stack([column, row], dim=-1).float()[None, None]


def decode(raw: Tensor, anchors: Tensor, stride: int) -> Tensor:
    """Boxes and scores of one head.

    Args:
        raw: Head output, shape (b, 3, rows, columns, 5 + classes).
        anchors: Anchor sizes of this head [px], shape (3, 2).
        stride: Picture pixels per cell.

    Returns:
        (centre u, centre v, width, height [px], objectness, class scores), shape (b, n, 5 + classes).
    """
    chance = raw.sigmoid()
    centre = (chance[..., 0:2] * 2.0 - 0.5 + cells(raw.shape[2], raw.shape[3])) * stride
    size = (chance[..., 2:4] * 2.0) ** 2 * anchors.view(1, ANCHORS_PER_CELL, 1, 1, 2)
    return torch.cat([centre, size, chance[..., 4:]], dim=-1).flatten(1, 3)


def predictions(model: Yolov5s, picture: Tensor) -> Tensor:
    """Decoded predictions of all heads, shape (b, N, 5 + classes); see `decode`."""
    raw = model(picture)
    return torch.cat(
        [decode(r.float(), a, s) for r, a, s in zip(raw, model.anchors, STRIDES, strict=True)], dim=1
    )
