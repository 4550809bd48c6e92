"""`bathbot bench`: how fast the program is on this machine."""

from pathlib import Path

import typer

from bathbot_bringup.command.arguments import writable

app = typer.Typer(help="Measure speed on this machine.", no_args_is_help=False, rich_markup_mode=None)


@app.callback()
def _group() -> None:
    """Measure speed on this machine."""


@app.command("depth")
def depth(
    json_file: Path = typer.Option(
        None, "--json", callback=writable, help="Write the numbers to this file too."
    ),
    seconds: float = typer.Option(20.0, help="How long the node is watched [s]."),
    rate: float = typer.Option(30.0, help="Frames per second of the camera [Hz]."),
    size: str = typer.Option("1280x720", help="Width and height of the frames [px]."),
) -> None:
    """Time the depth correction, alone and as the node under a camera's stream.

    The node runs as a process of its own and gets frames over DDS from another; nothing else hears them.

    \b
      bathbot bench depth --json depth.json
      bathbot bench depth --size 848x480 --rate 60
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bench.depth import DepthBench, bench_depth
    from bathbot_bringup.command.arguments import picture_size

    bench_depth(DepthBench(picture_size(size), rate, seconds), json_file)


@app.command("arm")
def arm(
    json_file: Path = typer.Option(
        None, "--json", callback=writable, help="Write the numbers to this file too."
    ),
    seconds: float = typer.Option(600.0, help="How long the joint stream is watched [s]; 0: not at all."),
) -> None:
    """Time the arm's inverse kinematics beside EAIK and Pinocchio, and its joint stream.

    The stream is timed where it arrives, at the emulated controller, while the whole graph of the demo runs
    and the arm washes to and fro.

    \b
      bathbot bench arm --json arm.json
      bathbot bench arm --seconds 0
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bench.arm import ArmBench, bench_arm

    bench_arm(ArmBench(seconds), json_file)


@app.command("detector")
def detector(
    json_file: Path = typer.Option(
        None, "--json", callback=writable, help="Write the numbers to this file too."
    ),
    rounds: int = typer.Option(150, help="Pictures per model."),
    threads: int = typer.Option(2, min=1, help="CPU threads of the network."),
    size: int = typer.Option(0, help="Longer side of the input [px]; 0: as the models say."),
) -> None:
    """Time the skin detector in float32 and INT8, with and without the node's own work.

    A simulated person as the camera sends it, 848x480: message in, message out, and ONNX Runtime alone on
    the same picture, in turns.

    \b
      bathbot bench detector --json detector.json
      bathbot bench detector --threads 1
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bench.detector import DetectorBench, bench_detector

    bench_detector(DetectorBench(rounds, threads, size), json_file)
