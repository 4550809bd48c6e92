"""Train the skin detector: `python -m bathbot_perception.training.train DATASET... --out DIR`.

From labelled pictures to checkpoints, curves, `DIR/skin.onnx` and `DIR/skin_int8.onnx`, in one command.

Warm-up then cosine, gradients in bfloat16, weights averaged. The schedule is a share of a budget in
minutes, so a run ends when it should on a slow machine too. A run that was stopped goes on with
`--resume`, also with other data sets than before; `--weights` begins a new run with an old one's weights.
"""

import argparse
import signal
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from bathbot_perception.errors import PerceptionError, SettingsError
from bathbot_perception.export.quantise import PICTURES, quantise
from bathbot_perception.pictures.splits import split_samples
from bathbot_perception.pictures.voc import list_samples
from bathbot_perception.training.curves import draw_curves
from bathbot_perception.training.data.augment_geometry import Example
from bathbot_perception.training.data.batches import BatchSettings, stream_batches
from bathbot_perception.training.data.corrections import NO_CORRECTIONS, Corrections, read_corrections
from bathbot_perception.training.data.dataset import Source, load_example, load_source
from bathbot_perception.training.network.checkpoint import Run, save_run
from bathbot_perception.training.network.export import export
from bathbot_perception.training.parallel import Losses, ParallelGradient
from bathbot_perception.training.progress import RowLog, TrainingProgress
from bathbot_perception.training.run import start_run, train_step, validate_run
from bathbot_perception.training.settings import TrainSettings, rate_at

_ROW = 50  # steps between rows of the log


class Gathered(NamedTuple):
    """What to train on, what to validate on by data set, and pictures that set the ranges of INT8."""

    sources: list[Source]
    held_out: dict[str, list[Example]]
    pictures: list[Path]


def stop_on_signal() -> threading.Event:
    """An event that SIGINT and SIGTERM set."""
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    return stopping


def train_until(
    run: Run,
    data: Gathered,
    settings: TrainSettings,
    out: Path,
    until: float,
    mosaic: float,
    progress: TrainingProgress,
) -> None:
    """Train until a share of the budget is used, with checkpoints and validation on the way."""
    budget = settings.minutes * 60
    saved = validated = run.seconds
    gradient = ParallelGradient(run.model, settings.threads)
    counted, began, losses = run.step, run.seconds, []
    drawn = BatchSettings(settings.batch, settings.long_side, mosaic, settings.shares)
    batches = stream_batches(data.sources, drawn, settings.seed + run.step)
    stopping = stop_on_signal()
    while run.seconds < until * budget and not stopping.is_set():
        start = time.monotonic()
        frozen = run.seconds < run.freeze_until * budget
        rate = rate_at(run.step, run.seconds / budget, settings)
        losses.append(train_step(run, gradient, next(batches), rate, frozen))
        run.seconds += time.monotonic() - start
        over = run.seconds >= until * budget or stopping.is_set()
        if run.step - counted >= _ROW or over:
            speed = (run.step - counted) * settings.batch / (run.seconds - began)
            progress.tell(_log(run, out, speed, rate, losses), run.seconds)
            counted, began, losses = run.step, run.seconds, []
        if run.seconds - saved > settings.checkpoint_minutes * 60:
            saved = run.seconds
            save_run(out / "last.pt", run)
        if run.seconds - validated > settings.validate_minutes * 60:
            validated = run.seconds
            validate_run(run, data.held_out, settings, out, progress.say)
            draw_curves(out)
    batches.close()
    gradient.close()
    save_run(out / "last.pt", run)
    if stopping.is_set():
        raise SystemExit(f"stopped; go on with --resume {out / 'last.pt'}")


def _log(run: Run, out: Path, speed: float, rate: float, losses: list[Losses]) -> dict[str, float]:
    """Add a row to training.csv."""
    box, objectness, category = np.mean(losses, axis=0)
    row = {
        "step": run.step,
        "minutes": round(run.seconds / 60, 2),
        "images_per_s": round(speed, 1),
        "rate": round(rate, 7),
        "box": round(float(box), 5),
        "objectness": round(float(objectness), 5),
        "class": round(float(category), 5),
    }
    RowLog(out / "training.csv").add(row)
    return row


def gather(
    folders: Sequence[Path],
    whole: Sequence[Path],
    held: Sequence[Path],
    long_side: int,
    progress: TrainingProgress,
    corrections: Corrections = NO_CORRECTIONS,
) -> Gathered:
    """Load the pictures to train on, with corrected boxes, and those to validate on by data set."""
    data = Gathered([], {}, [])
    for folder in folders:
        split = split_samples(folder)
        data.sources.append(load_source(folder, split.train, long_side, corrections))
        data.held_out[_name(folder)] = [load_example(sample, long_side) for sample in split.val]
        data.pictures.extend(sample.picture for sample in split.train)
        progress.say(f"{folder}: {len(split.train)} train, {len(split.val)} validate, {len(split.test)} test")
    for folder in whole:
        samples = list_samples(folder)
        data.sources.append(load_source(folder, samples, long_side))
        data.pictures.extend(sample.picture for sample in samples)
        progress.say(f"{folder}: {len(samples)} train")
    for folder in held:
        data.held_out[_name(folder)] = [load_example(sample, long_side) for sample in list_samples(folder)]
        progress.say(f"{folder}: {len(data.held_out[_name(folder)])} validate")
    if not data.sources:
        raise SettingsError("no data set to train on; name at least one folder with images/ and annotations/")
    return data


def _name(folder: Path) -> str:
    return "/".join(folder.resolve().parts[-2:])


def train(
    folders: Sequence[Path],
    out: Path,
    settings: TrainSettings,
    resume: Path | None = None,
    weights: Path | None = None,
    whole: Sequence[Path] = (),
    held: Sequence[Path] = (),
    corrections: Path | None = None,
) -> Path:
    """Train on data sets of VOC form and return the ONNX file.

    Args:
        folders: Data sets with `images/` and `annotations/`, each split 60/20/20 by picture.
        out: Folder for checkpoints (`last.pt`, `best.pt`), `training.csv`, `validation.csv`, `curves.png`,
            `skin.onnx` and `skin_int8.onnx`.
        settings: See `TrainSettings`; `shares` follow `folders`, then `whole`.
        resume: Checkpoint to go on from.
        weights: Checkpoint or float ONNX model whose weights begin a new run.
        whole: Data sets of which every picture trains.
        held: Data sets of which every picture validates.
        corrections: File of better boxes for training pictures of `folders`, see `corrections`.
    """
    cv2.setNumThreads(1)
    out.mkdir(parents=True, exist_ok=True)
    with TrainingProgress(settings.minutes * 60) as progress:
        better = read_corrections(corrections) if corrections else NO_CORRECTIONS
        data = gather(folders, whole, held, settings.long_side, progress, better)
        run = start_run(data.sources, settings, resume, weights)
        anchors = run.model.anchors.reshape(-1, 2).round().int().tolist()
        progress.say(f"anchors [px]: {anchors}; {asdict(settings)}")
        train_until(run, data, settings, out, settings.mosaic_until, settings.mosaic, progress)
        train_until(run, data, settings, out, 1.0, 0.0, progress)
        validate_run(run, data.held_out, settings, out, progress.say)
        draw_curves(out)
        export(out / "last.pt", out / "skin.onnx", settings.long_side)
        chosen = np.random.default_rng(settings.seed).permutation(len(data.pictures))[:PICTURES]
        quantise(out / "skin.onnx", [data.pictures[index] for index in chosen], out / "skin_int8.onnx")
    return out / "skin.onnx"


def main() -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description="Train the skin detector on PASCAL VOC data sets.")
    parser.add_argument("datasets", nargs="*", type=Path, help="split 60/20/20 by picture")
    parser.add_argument("--whole", nargs="*", type=Path, default=[], help="data sets that only train")
    parser.add_argument("--held", nargs="*", type=Path, default=[], help="data sets that only validate")
    parser.add_argument("--corrections", type=Path, help="JSON file of better boxes for training pictures")
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument(
        "--resume", type=Path, help="checkpoint to go on from, with its optimiser, decay and frozen share"
    )
    parser.add_argument("--weights", type=Path, help="checkpoint or ONNX model whose weights begin a new run")
    for name, value in asdict(TrainSettings()).items():
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, tuple):
            parser.add_argument(option, type=float, nargs="*", default=list(value))
        else:
            parser.add_argument(option, type=type(value), default=value)
    given = vars(parser.parse_args())
    names = ("datasets", "out", "resume", "weights", "whole", "held", "corrections")
    chosen = {key: given.pop(key) for key in names}
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in given.items()}
    try:
        train(chosen.pop("datasets"), chosen.pop("out"), TrainSettings(**values), **chosen)
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
