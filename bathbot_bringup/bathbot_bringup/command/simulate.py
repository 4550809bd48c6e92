"""`bathbot simulate`: bags of the simulated calibration scenes."""

from pathlib import Path

import typer

app = typer.Typer(
    help="Record simulated calibration scenes, to try the calibrations on.", rich_markup_mode=None
)


@app.callback()
def _group() -> None:
    """Record simulated calibration scenes, to try the calibrations on."""


@app.command("board")
def board(
    out: Path = typer.Option(..., "--out", help="Bag to make: a new folder, or a new file ending in .mcap."),
    poses: int = typer.Option(24, min=1, max=200, help="Places at which the camera stands still."),
    seed: int = typer.Option(0, min=0, help="Of the places and of the noise."),
    preset: str = typer.Option(
        "paper", help="Error model of the simulated depth camera: paper, yaw, good or perfect."
    ),
    size: str = typer.Option("848x480", help="Size of both pictures [px], 16:9, 320 to 1280 wide."),
) -> None:
    """Record a chessboard on a wall, seen from many places; takes 3 s a place.

    \b
      bathbot simulate board --out board
      bathbot calibrate depth board --out depth.npz
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.calibration.scenes import BoardScene, simulate_board
    from bathbot_bringup.command.arguments import picture_size

    _tell(simulate_board(BoardScene(out, poses, seed, preset, picture_size(size))), out)


@app.command("marker")
def marker(
    out: Path = typer.Option(..., "--out", help="Bag to make: a new folder, or a new file ending in .mcap."),
    poses: int = typer.Option(24, min=1, max=100, help="Arm poses in which the marker is shown."),
    seed: int = typer.Option(0, min=0, help="Of the arm poses and of the noise."),
) -> None:
    """Record a marker on the arm, shown to the camera in many poses; takes about 4 s a pose.

    \b
      bathbot simulate marker --out marker
      bathbot calibrate hand-eye marker --out hand_eye.yaml
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.calibration.scenes import MarkerScene, simulate_marker

    _tell(simulate_marker(MarkerScene(out, poses, seed), typer.echo), out)


def _tell(messages: int, out: Path) -> None:
    typer.echo(f"wrote {messages} messages to {out}")
