"""Training batches, made by a thread while the network works."""

import queue
import threading
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from bathbot_perception.training.data.augment import photometric
from bathbot_perception.training.data.augment_geometry import (
    Example,
    GeometryRanges,
    cover_regions,
    mosaic,
    random_placement,
)
from bathbot_perception.training.data.dataset import Source

_COVERED = 0.2  # chance that cloth hangs before some regions of a picture


class BatchSettings(NamedTuple):
    """How batches are drawn."""

    size: int = 8
    long_side: int = 416
    mosaic: float = 0.6
    shares: tuple[float, ...] = ()
    """Chance of each source; empty means in proportion to their number of pictures."""


class Batch(NamedTuple):
    """Pictures in [0, 1], shape (b, 3, h, w), and targets as `loss.detection_loss` wants them."""

    pictures: Tensor
    targets: Tensor


def canvases(long_side: int) -> tuple[tuple[int, int], ...]:
    """Upright, lying and nearly square canvases (height, width) of about equal area, multiples of 32."""
    short = round(long_side * 0.7 / 32) * 32
    middle = round((long_side * short) ** 0.5 / 32) * 32
    return (long_side, short), (short, long_side), (middle, middle)


def draw_example(
    sources: list[Source], canvas: tuple[int, int], settings: BatchSettings, random: np.random.Generator
) -> Example:
    """One augmented example: a mosaic of four pictures or a single one."""
    shares = np.array(settings.shares or [len(source.examples) for source in sources], dtype=float)

    def pick() -> Example:
        source = sources[random.choice(len(sources), p=shares / shares.sum())]
        return source.examples[random.choice(len(source.examples), p=source.chances)]

    if random.random() < settings.mosaic:
        parts = [pick() for _ in range(4)]
        bases = [settings.long_side / max(part.picture.shape[:2]) for part in parts]
        example = mosaic(parts, canvas, bases, GeometryRanges(scale=(0.6, 1.6)), random)
    else:
        part = pick()
        whole = min(canvas[0] / part.picture.shape[0], canvas[1] / part.picture.shape[1])
        base = (whole * settings.long_side / max(part.picture.shape[:2])) ** 0.5
        example = random_placement(part, canvas, base, GeometryRanges(scale=(0.7, 1.5)), random)
    if random.random() < _COVERED:
        example = cover_regions(example, random)
    return example._replace(picture=photometric(example.picture, random))


def draw_batch(sources: list[Source], settings: BatchSettings, random: np.random.Generator) -> Batch:
    """One batch on a canvas of random shape."""
    shapes = canvases(settings.long_side)
    canvas = shapes[random.integers(len(shapes))]
    examples = [draw_example(sources, canvas, settings, random) for _ in range(settings.size)]
    pictures = torch.from_numpy(np.stack([example.picture for example in examples]))
    rows = []
    for index, example in enumerate(examples):
        centre = (example.boxes[:, :2] + example.boxes[:, 2:]) / 2
        extent = example.boxes[:, 2:] - example.boxes[:, :2]
        rows.append(np.column_stack([np.full(len(centre), index), example.classes, centre, extent]))
    targets = torch.from_numpy(np.concatenate(rows)).float()
    return Batch(pictures.permute(0, 3, 1, 2).to(torch.float32) / 255.0, targets)


def stream_batches(
    sources: list[Source], settings: BatchSettings, seed: int, ahead: int = 4
) -> Iterator[Batch]:
    """Batches without end, `ahead` of them made in advance by one thread.

    Closing the iterator ends the thread. An error in the thread is raised here.
    """
    random = np.random.default_rng(seed)
    ready: queue.Queue[Batch | BaseException] = queue.Queue(ahead)
    closed = threading.Event()

    def work() -> None:
        while not closed.is_set():
            try:
                item: Batch | BaseException = draw_batch(sources, settings, random)
            except Exception as error:
                item = error
            while not closed.is_set():
                try:
                    ready.put(item, timeout=0.5)
                    break
                except queue.Full:
                    continue

    threading.Thread(target=work, daemon=True, name="batches").start()
    try:
        while True:
            item = ready.get()
            if isinstance(item, BaseException):
                raise item
            yield item
    finally:
        closed.set()
