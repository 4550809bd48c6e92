"""Augmentations that move boxes: flips, scales, translation, rotation, shear, mosaic, crop and pad."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.evaluation.effects import covered

Array = NDArray[np.floating]
GREY = (114, 114, 114)
"""Padding colour, the same as the detector's letterbox."""


class Example(NamedTuple):
    """A picture with its boxes while it is being trained on.

    `picture` is RGB uint8, shape (h, w, 3); `boxes` are (left, top, right, bottom) [px],
    shape (n, 4); `classes` are ids, shape (n,).
    """

    picture: NDArray[np.uint8]
    boxes: Array
    classes: NDArray[np.int64]


class GeometryRanges(NamedTuple):
    """How far one example may be moved."""

    scale: tuple[float, float] = (0.6, 1.6)
    stretch: float = 0.12
    rotation_deg: float = 8.0
    shear_deg: float = 3.0
    translate: float = 0.15
    perspective: float = 0.08
    """Share of width and height by which a corner may move inwards."""
    tilted: float = 0.15
    """Chance of a perspective transformation."""
    flip_sideways: float = 0.5
    flip_upside_down: float = 0.02


def flip(example: Example, sideways: bool) -> Example:
    """Mirror left and right if `sideways`, else top and bottom."""
    height, width = example.picture.shape[:2]
    left, top, right, bottom = example.boxes.T
    if sideways:
        boxes = np.stack([width - right, top, width - left, bottom], axis=1)
    else:
        boxes = np.stack([left, height - bottom, right, height - top], axis=1)
    return Example(
        np.ascontiguousarray(example.picture[:, ::-1] if sideways else example.picture[::-1]),
        boxes,
        example.classes,
    )


def placement(
    source: tuple[int, int],
    canvas: tuple[int, int],
    base: float,
    ranges: GeometryRanges,
    random: np.random.Generator,
) -> Array:
    """A random affine map from a picture to a canvas, shape (2, 3).

    Args:
        source: Height and width of the picture [px].
        canvas: Height and width of the canvas [px].
        base: Scale that counts as 1.
        ranges: Limits of the random values.
        random: Source of randomness.

    Returns:
        Map of homogeneous picture pixels to canvas pixels.
    """
    scale = base * np.exp(random.uniform(*np.log(ranges.scale)))
    stretch = np.exp(random.uniform(-ranges.stretch, ranges.stretch))
    angle = np.deg2rad(random.uniform(-ranges.rotation_deg, ranges.rotation_deg))
    shear = np.tan(np.deg2rad(random.uniform(-ranges.shear_deg, ranges.shear_deg)))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    linear = turn @ np.array([[1.0, shear], [0.0, 1.0]]) @ np.diag([scale * stretch, scale / stretch])
    size = np.array([canvas[1], canvas[0]], dtype=float)
    shown = np.abs(np.diag(linear)) * [source[1], source[0]]
    slack = np.maximum(size, shown) - np.minimum(size, shown)
    middle = (
        size / 2
        + random.uniform(-0.5, 0.5, 2) * slack
        + random.uniform(-1, 1, 2) * ranges.translate * np.minimum(size, shown)
    )
    offset = middle - linear @ (np.array([source[1], source[0]]) / 2)
    return np.column_stack([linear, offset])


def move_boxes(boxes: Array, affine: Array) -> Array:
    """Upright boxes round affinely mapped ellipses inscribed in `boxes`, shape (n, 4).

    Body parts fill the middle of their boxes better than the corners, so the box of the
    inscribed ellipse grows less under rotation than the box of the four corners.
    """
    centre = (boxes[:, :2] + boxes[:, 2:]) / 2 @ affine[:, :2].T + affine[:, 2]
    half = (boxes[:, 2:] - boxes[:, :2]) / 2
    reach = np.sqrt((half**2) @ (affine[:, :2] ** 2).T)
    return np.concatenate([centre - reach, centre + reach], axis=1)


def keep_visible(example: Example, least: float = 0.25, smallest: float = 4.0) -> Example:
    """Cut boxes at the border; drop those of which less than `least` or `smallest` [px] is left."""
    height, width = example.picture.shape[:2]
    cut = np.clip(example.boxes, 0.0, [width, height, width, height])
    before = np.prod(example.boxes[:, 2:] - example.boxes[:, :2], axis=1)
    extent = cut[:, 2:] - cut[:, :2]
    keep = (np.prod(extent, axis=1) >= least * before) & (extent.min(axis=1, initial=np.inf) >= smallest)
    return Example(example.picture, cut[keep], example.classes[keep])


def place(example: Example, canvas: tuple[int, int], affine: Array) -> Example:
    """Draw the picture on a grey canvas (height, width) [px] through `affine`."""
    height, width = canvas
    shrinking = abs(np.linalg.det(affine[:, :2])) < 0.36
    picture = cv2.warpAffine(
        example.picture,
        affine,
        (width, height),
        flags=cv2.INTER_AREA if shrinking else cv2.INTER_LINEAR,
        borderValue=GREY,
    )
    return keep_visible(Example(picture, move_boxes(example.boxes, affine), example.classes))


def tilt(example: Example, corners: Array) -> Example:
    """Perspective transformation: the picture as seen askew.

    Args:
        example: What to transform; the picture keeps its size.
        corners: Where upper left, upper right, lower right and lower left come to [px], shape (4, 2).
    """
    height, width = example.picture.shape[:2]
    begin = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    homography = cv2.getPerspectiveTransform(begin, corners.astype(np.float32))
    picture = cv2.warpPerspective(example.picture, homography, (width, height), borderValue=GREY)
    around = np.linspace(0.0, 2.0 * np.pi, 33)
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    centre = (example.boxes[:, :2] + example.boxes[:, 2:]) / 2
    half = (example.boxes[:, 2:] - example.boxes[:, :2]) / 2
    ellipses = (centre[:, None] + half[:, None] * circle).reshape(-1, 1, 2)
    if len(ellipses):
        ellipses = cv2.perspectiveTransform(ellipses, homography)
    ellipses = ellipses.reshape(-1, len(circle), 2)
    boxes = np.concatenate([ellipses.min(axis=1), ellipses.max(axis=1)], axis=1)
    return keep_visible(Example(picture, boxes, example.classes))


def random_tilt(example: Example, most: float, random: np.random.Generator) -> Example:
    """Move every corner inwards by up to a share `most` of width and height."""
    height, width = example.picture.shape[:2]
    inwards = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * random.uniform(0.0, most, (4, 2))
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + inwards
    return tilt(example, corners * [width, height])


def random_placement(
    example: Example,
    canvas: tuple[int, int],
    base: float,
    ranges: GeometryRanges,
    random: np.random.Generator,
) -> Example:
    """Flip, tilt, scale, stretch, rotate, shear, move, and so crop and pad one example at random."""
    if random.random() < ranges.flip_sideways:
        example = flip(example, sideways=True)
    if random.random() < ranges.flip_upside_down:
        example = flip(example, sideways=False)
    if random.random() < ranges.tilted:
        example = random_tilt(example, ranges.perspective, random)
    return place(example, canvas, placement(example.picture.shape[:2], canvas, base, ranges, random))


def mosaic(
    examples: list[Example],
    canvas: tuple[int, int],
    bases: list[float],
    ranges: GeometryRanges,
    random: np.random.Generator,
) -> Example:
    """Four examples in the four quarters of a canvas, meeting at a random point."""
    height, width = canvas
    column = int(width * random.uniform(0.3, 0.7))
    row = int(height * random.uniform(0.3, 0.7))
    quarters = [
        (0, 0, column, row),
        (column, 0, width, row),
        (0, row, column, height),
        (column, row, width, height),
    ]
    picture = np.empty((height, width, 3), np.uint8)
    boxes, classes = [], []
    for example, base, (left, top, right, bottom) in zip(examples, bases, quarters, strict=True):
        part = random_placement(example, (bottom - top, right - left), base, ranges, random)
        picture[top:bottom, left:right] = part.picture
        boxes.append(part.boxes + np.array([left, top, left, top]))
        classes.append(part.classes)
    return Example(picture, np.concatenate(boxes), np.concatenate(classes))


def cover_regions(example: Example, random: np.random.Generator, chance: float = 0.4) -> Example:
    """Hang cloth before some boxes that hides 5 to 40 % of each; the boxes stay as they are."""
    chosen = example.boxes[random.random(len(example.boxes)) < chance]
    return example._replace(picture=covered(example.picture, chosen, random.uniform(0.05, 0.4), random))
