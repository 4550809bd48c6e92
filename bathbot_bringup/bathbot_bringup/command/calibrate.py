"""`bathbot calibrate`: make calibrations from recorded bags."""

from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from bathbot_bringup.command.arguments import writable

app = typer.Typer(
    help="Calibrate the camera's depth, or its place beside the arm.",
    no_args_is_help=False,
    rich_markup_mode=None,
)


@app.callback()
def _group() -> None:
    """Calibrate the camera's depth, or its place beside the arm."""


class _TellsModels(TyperCommand):
    """A command whose help says a line about each depth model; they are imported only then."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        from bathbot_depthcorr.models.table import MODELS

        super().format_options(ctx, formatter)
        with formatter.section("Depth models"):
            formatter.write_dl([(name, model.about) for name, model in MODELS.items()])


@app.command("depth", cls=_TellsModels)
def depth(
    source: Path = typer.Argument(
        None,
        metavar="[BAG]",
        help="Bag of a chessboard on a flat wall, recorded with --profile full; or a folder of .npz "
        "views with known planes.",
    ),
    out: Path = typer.Option(
        ...,
        "--out",
        callback=writable,
        help="Calibration file to write, ending in .npz; a picture goes beside it.",
    ),
    model: str = typer.Option(None, "--model", help="Depth model, see below; the first is the default."),
    board: str = typer.Option("11x8", help="Inner corners of the board, along x across."),
    square: float = typer.Option(
        0.05, min=0.001, help="Edge of a square [m]; measure it, do not trust the print."
    ),
    live: bool = typer.Option(
        False, "--live", help="Watch the camera that runs now, and tell which poses are still missing."
    ),
    camera: str = typer.Option("camera/camera", help="With --live: namespace of the camera's topics."),
    json: Path = typer.Option(
        None, "--json", callback=writable, help="Also write the numbers of the report to this file."
    ),
    views: Path = typer.Option(
        None, "--views", help="Also write the views, depth and plane without colour, to this folder."
    ),
) -> None:
    """Fit the depth correction of one camera, and judge it on poses that were held out.

    Hold the camera still for a second at 18 or more poses, 0.4 to 1.5 m from the wall, tilted up to
    25 degrees, so that the wall fills the picture. Raw depth is needed, not depth aligned to colour.

    \b
      bathbot record --out wall --profile full --who nobody --when 2026-01-31 --why "chessboard only"
      bathbot calibrate depth wall --out d455.npz
      bathbot calibrate depth --live --out d455.npz
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_depthcorr.models.table import DEFAULT_MODEL
    from bathbot_depthcorr.views.chessboard import Chessboard

    from bathbot_bringup.calibration.depth_job import Job, run_job
    from bathbot_bringup.command.arguments import board_size

    chessboard = Chessboard(*board_size(board), square)
    model = DEFAULT_MODEL if model is None else model
    run_job(Job(source, live, camera, chessboard, model, out, json, views))


@app.command("hand-eye")
def hand_eye(
    bag: Path = typer.Argument(..., help="Bag of a marker on the arm, recorded with --profile full."),
    out: Path = typer.Option(
        ..., "--out", callback=writable, help="Calibration file to write, ending in .yaml."
    ),
) -> None:
    """Find where the camera stands beside the arm, from an ArUco marker that the arm shows it.

    Fix the marker to the scrub head and show it to the camera, still for a second, in 12 or more
    arm poses that differ by large turns about two axes.

    \b
      bathbot record --out marker --profile full --who nobody --when 2026-01-31 --why "marker only"
      bathbot calibrate hand-eye marker --out hand_eye.yaml
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_localize.hand_eye.recording import calibrate_bag

    from bathbot_bringup.bag.reading import check_whole

    check_whole(bag)
    for line in calibrate_bag(bag, out, progress=typer.echo).lines():
        typer.echo(line)
