"""`bathbot train`, `export`: make models, and write them in the form another machine wants."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

import typer

from bathbot_bringup.command.arguments import unused_folder, writable
from bathbot_bringup.errors import InputError

train = typer.Typer(help="Train models.", no_args_is_help=False, rich_markup_mode=None)
export = typer.Typer(help="Write models for other machines.", no_args_is_help=False, rich_markup_mode=None)


@train.callback()
def _train() -> None:
    """Train models."""


@export.callback()
def _export() -> None:
    """Write models for other machines."""


@train.command("detector")
def train_detector(
    datasets: list[Path] = typer.Argument(
        ..., metavar="DATASET...", help="PASCAL VOC folders: images/, annotations/; each is split 60/20/20."
    ),
    out: Path = typer.Option(..., "--out", help="Folder for models, checkpoints, curves and the log."),
    minutes: float = typer.Option(90.0, min=0.01, help="Budget of training time."),
    whole: list[Path] = typer.Option([], help="Data set of which every picture trains, such as renders."),
    held: list[Path] = typer.Option([], help="Data set of which every picture validates."),
    corrections: Path = typer.Option(None, help="JSON file of better boxes for training pictures."),
    size: int = typer.Option(640, help="Longer side of the pictures in training [px], a multiple of 32."),
    batch: int = typer.Option(12, min=1, help="Pictures per step."),
    optimiser: str = typer.Option(None, help="adamw, the default, or sgd as in the paper."),
    rate: float = typer.Option(0.001, help="Learning rate after warm-up."),
    decay: float = typer.Option(None, help="Weight decay; 0.01 with sgd, else 0.02."),
    frozen: float = typer.Option(None, min=0.0, max=0.9, help="Share of the time with a frozen backbone."),
    weights: Path = typer.Option(None, help="Model or checkpoint to begin with; else bathbot's own model."),
    scratch: bool = typer.Option(False, "--scratch", help="Begin with random weights."),
    resume: Path = typer.Option(None, help="Checkpoint of a run that was stopped, to go on with."),
    seed: int = typer.Option(0, help="Of the order of pictures and of all augmentations."),
) -> None:
    """Train the skin detector on labelled pictures, from bathbot's own model on.

    Two phases: the backbone is frozen for a fifth of the time, then free. Writes skin.onnx, skin_int8.onnx,
    curves.png and checkpoints; Ctrl-C stops at a checkpoint. An evening on two cores is enough to fine-tune.
    Needs PyTorch, which bathbot does not install: `pip install torch` in this environment.

    \b
      bathbot train detector my_photos --out training --minutes 60
      bathbot train detector my_photos more_photos --out training --resume training/last.pt
      bathbot train detector my_photos --out training --optimiser sgd --frozen 0.3
    """  # noqa: D301 - \b keeps the lines of examples
    files = {"--weights": weights, "--resume": resume, "--corrections": corrections}
    for path in [*datasets, *whole, *held, *filter(None, files.values())]:
        if not path.exists():
            raise InputError(f"there is no {path}; data sets are folders with images/ and annotations/")
    if sum(map(bool, (weights, scratch, resume))) > 1:
        raise InputError("--weights, --scratch and --resume exclude each other; choose one")
    if resume and any(value is not None for value in (optimiser, decay, frozen)):
        raise InputError("a run that goes on keeps its optimiser, decay and frozen share; leave them out")
    if not resume:
        unused_folder(out)
    if find_spec("torch") is None:
        raise InputError(
            "training needs PyTorch, which is not installed here; run `pip install torch` and try again"
        )
    from bathbot_perception.detection.detector import DEFAULT_MODEL

    if not (scratch or resume or weights):
        files["--weights"] = DEFAULT_MODEL
    paper = optimiser == "sgd"
    options = {
        "--minutes": minutes,
        "--long-side": size,
        "--batch": batch,
        "--optimiser": optimiser or "adamw",
        "--rate": rate,
        "--decay": decay if decay is not None else 0.01 if paper else 0.02,
        "--freeze-until": frozen if frozen is not None else 0.0 if scratch else 0.2,
        "--seed": seed,
        **{name: path for name, path in files.items() if path},
    }
    command = [
        sys.executable,
        "-m",
        "bathbot_perception.training.train",
        *map(str, datasets),
        "--out",
        str(out),
    ]
    for name, folders in (("--whole", whole), ("--held", held)):
        command += [name, *map(str, folders)] if folders else []
    command += [part for name, value in options.items() for part in (name, str(value))]
    os.execv(sys.executable, command)


@export.command("detector")
def export_detector(
    out: Path = typer.Option(..., "--out", callback=writable, help="ONNX file to write."),
    model: str = typer.Option("", help="ONNX file; leave it out for the model that comes with bathbot."),
    precision: str = typer.Option(
        "fp16", help="fp32, fp16 (GPUs such as a Jetson TX2's) or int8 (CPUs; takes uint8)."
    ),
    shape: str = typer.Option("", help="Width and height of the input [px] for one shape only: 640x384."),
    dataset: Path = typer.Option(
        None, help="PASCAL VOC folder whose training pictures set the ranges of int8."
    ),
) -> None:
    """Write the skin detector in another precision or for one shape of input, as TensorRT wants it.

    The file is ONNX of opset 13, which TensorRT 8.2 reads; docs/jetson_tx2.md says how to go on there.

    \b
      bathbot export detector --precision fp16 --shape 640x384 --out skin_fp16.onnx
      bathbot export detector --precision int8 --dataset my_photos --out skin_int8.onnx
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_perception.detection.detector import model_file
    from bathbot_perception.export.convert import convert
    from bathbot_perception.export.quantise import PICTURES
    from bathbot_perception.pictures.splits import split_samples
    from rich.console import Console

    from bathbot_bringup.command.arguments import picture_size

    width, height = picture_size(shape) if shape else (0, 0)
    pictures = [sample.picture for sample in split_samples(dataset).train[:PICTURES]] if dataset else []
    console = Console(highlight=False, soft_wrap=True)
    with console.status(f"writing {out}"):
        made = convert(model_file(model), out, precision, (height, width) if shape else None, pictures)
    taken = f"{width}x{height} px only" if shape else "any multiples of 32 px"
    console.print(
        f"{out}: {precision}, {made.size_mb:.1f} MB, opset {made.opset}, input {taken}; "
        f"differs from the model it came from by {made.difference:.3g} px or score at most, on noise",
        markup=False,
    )
