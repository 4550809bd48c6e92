"""`bathbot calibrate`: make calibrations from recorded bags."""

from pathlib import Path

import typer

app = typer.Typer(
    help="Calibrate the camera's depth, or its place beside the arm.",
    no_args_is_help=False,
    rich_markup_mode=None,
)


@app.callback()
def _group() -> None:
    """Calibrate the camera's depth, or its place beside the arm."""


@app.command("depth")
def depth(
    bag: Path = typer.Argument(
        ..., help="Bag of a chessboard on a flat wall, recorded with --profile calibration."
    ),
    out: Path = typer.Option(
        ..., "--out", help="Calibration file to write, ending in .npz; a picture goes beside it."
    ),
    model: str = typer.Option(
        "disparity_spline", help="Depth model: disparity_spline, two_stage or identity."
    ),
    board: str = typer.Option("11x8", help="Inner corners of the board, along x across."),
    square: float = typer.Option(
        0.05, min=0.001, help="Edge of a square [m]; measure it, do not trust the print."
    ),
) -> None:
    """Fit the depth correction of one camera, and judge it on poses that were held out.

    Hold the camera still for a second at 18 or more poses, 0.4 to 1.5 m from the wall, tilted up to
    25 degrees, so that the wall fills the picture. Raw depth is needed, not depth aligned to colour.

    \b
      bathbot record --out wall --profile calibration --consent "chessboard only"
      bathbot calibrate depth wall --out d455.npz
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_depthcorr.calibrate import calibrate_bag

    from bathbot_bringup.arguments import board_size

    report = calibrate_bag(bag, out, model, board_size(board), square, progress=typer.echo)
    for line in report.lines():
        typer.echo(line)


@app.command("hand-eye")
def hand_eye(
    bag: Path = typer.Argument(..., help="Bag of a marker on the arm, recorded with --profile calibration."),
    out: Path = typer.Option(..., "--out", help="Calibration file to write, ending in .yaml."),
) -> None:
    """Find where the camera stands beside the arm, from an ArUco marker that the arm shows it.

    Fix the marker to the scrub head and show it to the camera, still for a second, in 12 or more
    arm poses that differ by large turns about two axes.

    \b
      bathbot record --out marker --profile calibration --consent "marker only"
      bathbot calibrate hand-eye marker --out hand_eye.yaml
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_localize.calibrate_hand_eye import calibrate_bag

    for line in calibrate_bag(bag, out, progress=typer.echo).lines():
        typer.echo(line)
