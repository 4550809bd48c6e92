"""`bathbot train`: make models."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

import typer

from bathbot_bringup.errors import InputError

app = typer.Typer(help="Train models.", no_args_is_help=False, rich_markup_mode=None)


@app.callback()
def _group() -> None:
    """Train models."""


@app.command("detector")
def detector(
    datasets: list[Path] = typer.Argument(
        ..., metavar="DATASET...", help="PASCAL VOC folders: images/, annotations/."
    ),
    out: Path = typer.Option(..., "--out", help="Folder for checkpoints and the log."),
    minutes: float = typer.Option(75.0, min=0.01, help="Budget of training time."),
    resume: Path = typer.Option(None, help="Checkpoint to go on from."),
) -> None:
    """Train the skin detector on labelled pictures.

    Needs PyTorch, which bathbot does not install: `pip install torch` in this environment.

    \b
      bathbot train detector my_photos --out training --minutes 60
      bathbot train detector my_photos more_photos --out training --resume training/last.pt
    """  # noqa: D301 - \b keeps the lines of examples
    for path in [*datasets, *([resume] if resume else [])]:
        if not path.exists():
            raise InputError(f"there is no {path}; data sets are folders with images/ and annotations/")
    if find_spec("torch") is None:
        raise InputError(
            "training needs PyTorch, which is not installed here; run `pip install torch` and try again"
        )
    command = [
        sys.executable,
        "-m",
        "bathbot_perception.training.train",
        *map(str, datasets),
        "--out",
        str(out),
    ]
    command += ["--minutes", str(minutes), *(["--resume", str(resume)] if resume else [])]
    os.execv(sys.executable, command)
