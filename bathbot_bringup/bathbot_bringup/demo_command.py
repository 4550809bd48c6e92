"""`bathbot demo`: the whole bathing job in the simulated bathroom."""

import time
from pathlib import Path

import typer


def demo(
    region: str = typer.Option("Trunk_skin", help="Region to bathe; trunk, upperlimb, ... will do."),
    seed: int = typer.Option(0, help="Body, skin tone, pose, motion and noise follow from it."),
    scenario: str = typer.Option(
        "calm", help="How the person moves: still, calm, breathing, ... or a YAML file."
    ),
    out: Path = typer.Option(None, help="Folder for the results; bathing/<date-time> if left out."),
    duration: float = typer.Option(60.0, help="Longest time of scrubbing [s]; the path is cut to it."),
    rate: float = typer.Option(5.0, help="Pictures per second of the simulated camera [Hz]."),
    preset: str = typer.Option(
        "paper", help="Error model of the simulated depth camera: paper, yaw or good."
    ),
) -> None:
    """Bathe a simulated person: see, correct, locate, approach, scrub, retract, go home.

    Starts every node as a process of its own on an isolated DDS domain, and ends them all again.
    Writes run.mcap, summary.json, report.html and logs/. The exit code is 0 only if the job was done.

    \b
      bathbot demo
      bathbot demo --region upperlimb --seed 3 --scenario restless --out bathing/arm
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing import full_region_name
    from bathbot_bringup.demo import run_demo
    from bathbot_bringup.demo_settings import DemoSettings

    folder = out or Path("bathing") / time.strftime("%Y%m%d-%H%M%S")
    settings = DemoSettings(full_region_name(region), seed, scenario, folder, duration, rate, preset)
    raise typer.Exit(run_demo(settings))
