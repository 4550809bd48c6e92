"""A training run: its beginning, one step, and how good it is now."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import TrainingError
from bathbot_perception.training.data.augment_geometry import Example
from bathbot_perception.training.data.batches import Batch, BatchSettings, draw_batch
from bathbot_perception.training.data.dataset import Source
from bathbot_perception.training.network.anchors import cluster_anchors
from bathbot_perception.training.network.checkpoint import (
    Average,
    Run,
    averaged_network,
    optimiser_of,
    read_state,
    restore_run,
    save_run,
)
from bathbot_perception.training.network.network import Yolov5s
from bathbot_perception.training.network.unfold import network_from_onnx
from bathbot_perception.training.parallel import Losses, ParallelGradient
from bathbot_perception.training.progress import RowLog
from bathbot_perception.training.settings import TrainSettings
from bathbot_perception.training.validate import score_network

_MOST_LOST = 20  # steps in a row
_SHOWN = 24  # pictures that give a network from an ONNX file its norms


def make_optimiser(model: Yolov5s, settings: TrainSettings) -> torch.optim.Optimizer:
    """AdamW, or SGD with momentum, that shrinks convolution weights only, not biases or norms."""
    shrinking = [p for p in model.parameters() if p.ndim > 1]
    free = [p for p in model.parameters() if p.ndim <= 1]
    groups = [{"params": shrinking, "weight_decay": settings.decay}, {"params": free, "weight_decay": 0.0}]
    if settings.optimiser == "sgd":
        return torch.optim.SGD(groups, lr=settings.rate, momentum=0.937, nesterov=True)  # fused cannot thaw
    return torch.optim.AdamW(groups, lr=settings.rate, betas=(0.9, 0.99), fused=True)


def start_run(
    sources: list[Source], settings: TrainSettings, resume: Path | None, weights: Path | None = None
) -> Run:
    """A new run with anchors from the data, or with averaged `weights`, or the one at `resume`.

    Args:
        sources: Training data.
        settings: Of the run; one that goes on keeps its optimiser, decay and frozen share.
        resume: Checkpoint to go on from.
        weights: Checkpoint or float ONNX file whose weights begin a new run.
    """
    torch.manual_seed(settings.seed)
    if resume is not None:
        state = read_state(resume)
        own = replace(settings, optimiser=optimiser_of(state), freeze_until=state["freeze_until"])
        run = _run_with(averaged_network(state), state["size"], own)
        restore_run(run, state)
        scale_anchors(run, settings.long_side)
        return run
    if weights is None:
        network = Yolov5s(len(SKIN_CLASSES), new_anchors(sources, settings))
        return _run_with(network, settings.long_side, settings)
    if weights.suffix == ".onnx":
        random = np.random.default_rng(settings.seed)
        shown = draw_batch(sources, BatchSettings(_SHOWN, settings.long_side, 0.0, settings.shares), random)
        return _run_with(*network_from_onnx(weights, shown.pictures), settings)
    state = read_state(weights)
    return _run_with(averaged_network(state), state["size"], settings)


def _run_with(model: Yolov5s, size: int, settings: TrainSettings) -> Run:
    model = model.train().to(memory_format=torch.channels_last)
    run = Run(model, Average(model), make_optimiser(model, settings), size, settings.freeze_until)
    scale_anchors(run, settings.long_side)
    return run


def scale_anchors(run: Run, size: int) -> None:
    """Let the anchors grow with the pictures, so that every box keeps its anchor and its head."""
    for network in (run.model, run.average.model):
        network.anchors.mul_(size / run.size)
    run.size = size


def new_anchors(sources: list[Source], settings: TrainSettings) -> Tensor:
    """Anchors [px] from the boxes of all sources, at the magnifications of the settings, shape (9, 2)."""
    sizes = np.concatenate([_typical_sizes(source, settings.long_side) for source in sources])
    sizes = np.concatenate([sizes * scale for scale in settings.anchor_scales])
    return torch.from_numpy(cluster_anchors(sizes, seed=settings.seed))


def _typical_sizes(source: Source, long_side: int) -> np.ndarray:
    sizes = [
        (e.boxes[:, 2:] - e.boxes[:, :2]) * long_side / max(e.picture.shape[:2]) for e in source.examples
    ]
    return np.concatenate(sizes)


def train_step(run: Run, gradient: ParallelGradient, batch: Batch, rate: float, frozen: bool) -> Losses:
    """One step of gradient descent; returns the three parts of the loss.

    A gradient that is no number changes nothing: the step is left out and counted in `run.lost`.

    Raises:
        TrainingError: After many such steps in a row.
    """
    for group in run.optimiser.param_groups:
        group["lr"] = rate
    losses = gradient.compute(batch, frozen)
    norm = torch.nn.utils.clip_grad_norm_(run.model.parameters(), 10.0)
    run.step += 1
    if torch.isfinite(norm):
        run.optimiser.step()
        run.average.update(run.model)
        run.lost = 0
    else:
        run.lost += 1
        _mend_norms(run)
    run.optimiser.zero_grad(set_to_none=True)
    if run.lost > _MOST_LOST:
        raise TrainingError(
            f"the gradient was no number in {run.lost} steps in a row; go on from the last checkpoint with a "
            "lower rate"
        )
    return losses


@torch.no_grad()
def _mend_norms(run: Run) -> None:
    """Give norms that have seen numbers that are none the averaged means and variances again."""
    for ours, averaged in zip(run.model.buffers(), run.average.model.buffers(), strict=True):
        if not torch.isfinite(ours).all():
            ours.copy_(averaged)


def validate_run(
    run: Run,
    held_out: dict[str, list[Example]],
    settings: TrainSettings,
    out: Path,
    report: Callable[[str], None],
) -> float:
    """Score the averaged network on each data set, log it, keep the best; returns the mean mAP50."""
    values = []
    for name, examples in held_out.items():
        scores = score_network(run.average.model, examples, settings.long_side)
        values.append(scores["map50"])
        RowLog(out / "validation.csv").add(
            {"step": run.step, "minutes": round(run.seconds / 60, 2), "data": name, **scores}
        )
        report(f"{name}: " + " ".join(f"{key} {value:.3f}" for key, value in scores.items()))
    mean = float(np.mean(values)) if values else -1.0
    if mean >= run.best:
        run.best = mean
        save_run(out / "best.pt", run)
    return mean
