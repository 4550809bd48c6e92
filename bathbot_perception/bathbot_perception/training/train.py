"""Train the skin detector: `python -m bathbot_perception.training.train DATASET... --out DIR`.

From labelled pictures to checkpoints, curves as CSV, and `DIR/skin.onnx`, in one command.

AdamW, warm-up then cosine, gradients in bfloat16, weights averaged. The schedule is a share of
a budget in minutes, so a run ends when it should on a slow machine too. A run that was stopped
goes on with `--resume`, also with other data sets than before.
"""

import argparse
import signal
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
import torch

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import PerceptionError, SettingsError
from bathbot_perception.splits import split_samples
from bathbot_perception.training.anchors import cluster_anchors
from bathbot_perception.training.augment_geometry import Example
from bathbot_perception.training.batches import Batch, BatchSettings, stream_batches
from bathbot_perception.training.checkpoint import Average, Run, read_state, restore_run, save_run
from bathbot_perception.training.dataset import Source, load_example, load_source
from bathbot_perception.training.export import export
from bathbot_perception.training.network import Yolov5s
from bathbot_perception.training.parallel import Losses, ParallelGradient
from bathbot_perception.training.row_log import RowLog
from bathbot_perception.training.train_settings import TrainSettings, rate_at
from bathbot_perception.training.validate import score_network
from bathbot_perception.voc import list_samples


def make_optimiser(model: Yolov5s, settings: TrainSettings) -> torch.optim.Optimizer:
    """AdamW that shrinks convolution weights only, not biases or norms."""
    shrinking = [p for p in model.parameters() if p.ndim > 1]
    free = [p for p in model.parameters() if p.ndim <= 1]
    groups = [{"params": shrinking, "weight_decay": settings.decay}, {"params": free, "weight_decay": 0.0}]
    return torch.optim.AdamW(groups, lr=settings.rate, betas=(0.9, 0.99), fused=True)


def start_run(sources: list[Source], settings: TrainSettings, resume: Path | None) -> Run:
    """A new run with anchors from the data, or the one at `resume`."""
    torch.manual_seed(settings.seed)
    if resume is not None:
        state = read_state(resume)
        anchors = state["model"]["anchors"]
    else:
        sizes = np.concatenate([_typical_sizes(source, settings.long_side) for source in sources])
        sizes = np.concatenate([sizes * scale for scale in settings.anchor_scales])
        anchors = torch.from_numpy(cluster_anchors(sizes, seed=settings.seed))
    model = Yolov5s(len(SKIN_CLASSES), anchors).to(memory_format=torch.channels_last)
    run = Run(model, Average(model), make_optimiser(model, settings))
    if resume is not None:
        restore_run(run, state)
    return run


def _typical_sizes(source: Source, long_side: int) -> np.ndarray:
    sizes = [
        (e.boxes[:, 2:] - e.boxes[:, :2]) * long_side / max(e.picture.shape[:2]) for e in source.examples
    ]
    return np.concatenate(sizes)


def train_step(run: Run, gradient: ParallelGradient, batch: Batch, rate: float, frozen: bool) -> Losses:
    """One step of gradient descent; returns the three parts of the loss."""
    for group in run.optimiser.param_groups:
        group["lr"] = rate
    losses = gradient.compute(batch, frozen)
    torch.nn.utils.clip_grad_norm_(run.model.parameters(), 10.0)
    run.optimiser.step()
    run.optimiser.zero_grad(set_to_none=True)
    run.average.update(run.model)
    run.step += 1
    return losses


def validate_run(run: Run, held_out: dict[str, list[Example]], settings: TrainSettings, out: Path) -> float:
    """Score the averaged network on each data set, log it, keep the best; returns the mean mAP50."""
    values = []
    for name, examples in held_out.items():
        scores = score_network(run.average.model, examples, settings.long_side)
        values.append(scores["map50"])
        RowLog(out / "validation.csv").add(
            {"step": run.step, "minutes": round(run.seconds / 60, 2), "data": name, **scores}
        )
        print(f"  {name}: " + " ".join(f"{key} {value:.3f}" for key, value in scores.items()), flush=True)
    mean = float(np.mean(values)) if values else -1.0
    if mean >= run.best:
        run.best = mean
        save_run(out / "best.pt", run)
    return mean


def stop_on_signal() -> threading.Event:
    """An event that SIGINT and SIGTERM set."""
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    return stopping


def _batch_settings(settings: TrainSettings, mosaic: float) -> BatchSettings:
    return BatchSettings(settings.batch, settings.long_side, mosaic, settings.shares)


def train_until(
    run: Run,
    sources: list[Source],
    held_out: dict[str, list[Example]],
    settings: TrainSettings,
    out: Path,
    until: float,
    mosaic: float,
    report: Callable[[str], None],
) -> None:
    """Train until a share of the budget is used, with checkpoints and validation on the way."""
    budget = settings.minutes * 60
    saved = validated = run.seconds
    gradient = ParallelGradient(run.model, settings.threads)
    counted, began, losses = run.step, run.seconds, []
    batches = stream_batches(sources, _batch_settings(settings, mosaic), settings.seed + run.step)
    stopping = stop_on_signal()
    while run.seconds < until * budget and not stopping.is_set():
        start = time.monotonic()
        frozen = run.seconds < settings.freeze_until * budget
        batch = next(batches)
        rate = rate_at(run.step, run.seconds / budget, settings)
        losses.append(train_step(run, gradient, batch, rate, frozen))
        run.seconds += time.monotonic() - start
        if run.step - counted >= 50:
            speed = (run.step - counted) * settings.batch / (run.seconds - began)
            box, objectness, category = np.mean(losses, axis=0)
            RowLog(out / "training.csv").add(
                {
                    "step": run.step,
                    "minutes": round(run.seconds / 60, 2),
                    "images_per_s": round(speed, 1),
                    "rate": round(rate, 7),
                    "box": round(box, 5),
                    "objectness": round(objectness, 5),
                    "class": round(category, 5),
                }
            )
            report(
                f"step {run.step}  {run.seconds / 60:.1f}/{settings.minutes:.0f} min  {speed:.1f} images/s  "
                f"box {box:.4f} objectness {objectness:.4f} class {category:.4f}"
            )
            counted, began, losses = run.step, run.seconds, []
        if run.seconds - saved > settings.checkpoint_minutes * 60:
            saved = run.seconds
            save_run(out / "last.pt", run)
        if run.seconds - validated > settings.validate_minutes * 60:
            validated = run.seconds
            validate_run(run, held_out, settings, out)
    batches.close()
    gradient.close()
    save_run(out / "last.pt", run)
    if stopping.is_set():
        raise SystemExit(f"stopped; go on with --resume {out / 'last.pt'}")


def gather(
    folders: Sequence[Path], whole: Sequence[Path], held: Sequence[Path], long_side: int
) -> tuple[list[Source], dict[str, list[Example]]]:
    """Load the pictures to train on, and those to validate on by data set."""
    sources, held_out = [], {}
    for folder in folders:
        split = split_samples(folder)
        sources.append(load_source(folder, split.train, long_side))
        held_out[_name(folder)] = [load_example(sample, long_side) for sample in split.val]
        print(
            f"{folder}: {len(split.train)} train, {len(split.val)} validate, {len(split.test)} test",
            flush=True,
        )
    for folder in whole:
        sources.append(load_source(folder, list_samples(folder), long_side))
        print(f"{folder}: {len(sources[-1].examples)} train", flush=True)
    for folder in held:
        held_out[_name(folder)] = [load_example(sample, long_side) for sample in list_samples(folder)]
        print(f"{folder}: {len(held_out[_name(folder)])} validate", flush=True)
    return sources, held_out


def _name(folder: Path) -> str:
    return "/".join(folder.resolve().parts[-2:])


def train(
    folders: Sequence[Path],
    out: Path,
    settings: TrainSettings,
    resume: Path | None = None,
    whole: Sequence[Path] = (),
    held: Sequence[Path] = (),
) -> Path:
    """Train on data sets of VOC form and return the final checkpoint.

    Args:
        folders: Data sets with `images/` and `annotations/`, each split 60/20/20 by picture.
        out: Folder for checkpoints (`last.pt`, `best.pt`), `training.csv` and `validation.csv`.
        settings: See `TrainSettings`; `shares` follow `folders`, then `whole`.
        resume: Checkpoint to go on from.
        whole: Data sets of which every picture trains.
        held: Data sets of which every picture validates.
    """
    cv2.setNumThreads(1)
    out.mkdir(parents=True, exist_ok=True)
    sources, held_out = gather(folders, whole, held, settings.long_side)
    if not sources:
        raise SettingsError("no data set to train on; name at least one folder with images/ and annotations/")
    run = start_run(sources, settings, resume)
    print(
        f"anchors [px]: {run.model.anchors.reshape(-1, 2).round().int().tolist()}; {asdict(settings)}",
        flush=True,
    )

    def report(line: str) -> None:
        print(line, flush=True)

    train_until(run, sources, held_out, settings, out, settings.mosaic_until, settings.mosaic, report)
    train_until(run, sources, held_out, settings, out, 1.0, 0.0, report)
    validate_run(run, held_out, settings, out)
    return out / "last.pt"


def main() -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description="Train the skin detector on PASCAL VOC data sets.")
    parser.add_argument("datasets", nargs="*", type=Path, help="split 60/20/20 by picture")
    parser.add_argument("--whole", nargs="*", type=Path, default=[], help="data sets that only train")
    parser.add_argument("--held", nargs="*", type=Path, default=[], help="data sets that only validate")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--resume", type=Path, help="checkpoint to go on from")
    for name, value in asdict(TrainSettings()).items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, tuple):
            parser.add_argument(option, type=float, nargs="*", default=list(value))
        else:
            parser.add_argument(option, type=type(value), default=value)
    given = vars(parser.parse_args())
    chosen = {key: given.pop(key) for key in ("datasets", "out", "resume", "whole", "held")}
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in given.items()}
    try:
        settings = TrainSettings(**values)
        last = train(
            chosen["datasets"], chosen["out"], settings, chosen["resume"], chosen["whole"], chosen["held"]
        )
        export(last, chosen["out"] / "skin.onnx", settings.long_side)
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
