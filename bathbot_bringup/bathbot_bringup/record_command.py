"""`bathbot record`: write a bag of the running graph."""

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
    from bathbot_bringup.recording import record_graph

    summary = record_graph(out, profile, consent, seconds)
    for topic in summary:
        typer.echo(f"{topic.messages:8d}  {topic.name}  ({topic.message_type})")
    typer.echo(f"wrote {sum(topic.messages for topic in summary)} messages to {out}")
