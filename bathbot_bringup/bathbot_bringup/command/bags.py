"""`bathbot record` and `bathbot replay`: bags of what the graph says, and the pipeline over them again."""

from pathlib import Path

import typer


def record(
    out: Path = typer.Option(..., "--out", help="Bag to make: a new folder, or a new file ending in .mcap."),
    profile: str = typer.Option(
        "default", help="Privacy profile: default, arm or calibration; see docs/privacy.md."
    ),
    consent: str = typer.Option(
        "", help="Who agreed to be recorded, and when; profiles with pictures need it."
    ),
    seconds: float = typer.Option(0.0, min=0.0, help="Stop after so many seconds; 0 records until Ctrl-C."),
) -> None:
    """Record the topics that a privacy profile allows, until Ctrl-C.

    The default profile holds no picture of any kind, not even depth.

    \b
      bathbot record --out bathing/monday
      bathbot record --out board --profile calibration --consent "chessboard only" --seconds 60
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.record import record_graph

    summary = record_graph(out, profile, consent, seconds)
    for topic in summary:
        typer.echo(f"{topic.messages:8d}  {topic.name}  ({topic.message_type})")
    typer.echo(f"wrote {sum(topic.messages for topic in summary)} messages to {out}")


def replay(
    bag: Path = typer.Argument(..., help="rosbag2 folder or .mcap file."),
    rate: float = typer.Option(
        1.0, min=0.05, max=20.0, help="Speed; 0.5 is half as fast as it was recorded."
    ),
    out: Path = typer.Option(None, help="Record what comes out to this bag."),
    calibration: str = typer.Option(
        "", help="Depth calibration, .npz; leave it out for the one of the bag's camera."
    ),
    hand_eye: str = typer.Option(
        "", help="Hand-eye calibration, .yaml; leave it out for the one of the demo."
    ),
) -> None:
    """Publish a bag again, with its own time stamps, and run the pipeline over it; no live source is used.

    A bag with pictures goes through depth correction, detection and localisation again. A bag of the
    default privacy profile holds none: then what it holds is published and counted.

    \b
      bathbot replay bathing/monday
      bathbot replay with_pictures --rate 0.5 --out again
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.replay import replay_bag
    from bathbot_bringup.bag.replay_settings import ReplaySettings

    replay_bag(ReplaySettings(bag, rate, out, calibration, hand_eye))
