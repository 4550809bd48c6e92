"""`bathbot record`, `repair` and `replay`: bags of what the graph says, and the pipeline over them again."""

from pathlib import Path

import typer


def record(
    out: Path = typer.Option(..., "--out", help="Bag to make: a new folder, or a new file ending in .mcap."),
    profile: str = typer.Option(
        "metrics_only", help="Privacy profile: metrics_only, depth_only or full; see docs/privacy.md."
    ),
    who: str = typer.Option("", help="Who agreed to be recorded; profiles with pictures need it."),
    when: str = typer.Option("", help="When they agreed, such as 2026-01-31; likewise."),
    why: str = typer.Option("", help="What they agreed to: the purpose, and how long it is kept; likewise."),
    seconds: float = typer.Option(
        0.0, min=0.0, help="Stop so many seconds after the first message; 0 records until Ctrl-C."
    ),
) -> None:
    """Record the topics that a privacy profile allows, until Ctrl-C.

    The profile metrics_only holds no picture of any kind, not even depth.

    \b
      bathbot record --out bathing/monday
      bathbot record --out board --profile full --who nobody --when 2026-01-31 --why "chessboard only"
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.recording.privacy import Consent
    from bathbot_bringup.bag.recording.record import record_graph
    from bathbot_bringup.bag.recording.recorder import LOST, REFUSED

    until = f"{seconds:g} s after the first message" if seconds else "Ctrl-C"
    typer.echo(f"recording to {out} until {until}")
    summary, notes = record_graph(out, profile, Consent(who, when, why), seconds)
    for topic in summary:
        typer.echo(f"{topic.messages:8d}  {topic.name}  ({topic.message_type})")
    typer.echo(f"wrote {sum(topic.messages for topic in summary)} messages to {out}")
    for what in (LOST, REFUSED):
        if notes.get(what, "0") != "0":
            typer.echo(f"{notes[what]} messages were {what}", err=True)


def repair(
    bag: Path = typer.Argument(..., help="Folder or .mcap file that is damaged or was not closed."),
    out: Path = typer.Option(..., "--out", help="Bag to make: a new folder, or a new file ending in .mcap."),
) -> None:
    """Write what can be read of a bag to a new one, with an index; the old one stays.

    A bag whose recorder was killed opens as it lies; without an index every look into it reads all of it.

    \b
      bathbot repair bathing/monday --out bathing/monday_again
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.repair import repair_bag

    done = repair_bag(bag, out)
    typer.echo(f"wrote {done.messages} messages to {out}")
    if done.trouble:
        typer.echo(f"{done.damaged} parts of {bag} could not be read, the last for: {done.trouble}", err=True)


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
    privacy profile metrics_only holds none: then what it holds is published and counted.

    \b
      bathbot replay bathing/monday
      bathbot replay with_pictures --rate 0.5 --out again
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.replaying.replay import replay_bag
    from bathbot_bringup.bag.replaying.replay_settings import ReplaySettings

    replay_bag(ReplaySettings(bag, rate, out, calibration, hand_eye))
