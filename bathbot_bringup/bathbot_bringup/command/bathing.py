"""`bathbot demo` and `bathbot bathe`: the whole bathing job, simulated or with the nodes that run here."""

import time
from pathlib import Path

import typer

from bathbot_bringup.command.arguments import CALIBRATION, PRESET, RATE


def demo(
    region: str = typer.Option("Trunk_skin", help="Region to bathe; trunk, upperlimb, ... will do."),
    seed: int = typer.Option(0, help="Body, skin tone, pose, motion and noise follow from it."),
    scenario: str = typer.Option(
        "calm", help="How the person moves: still, calm, breathing, ... or a YAML file."
    ),
    out: Path = typer.Option(None, help="Folder for the results; bathing/<date-time> if left out."),
    duration: float = typer.Option(60.0, help="Longest time of scrubbing [s]; the path is cut to it."),
    rate: float = RATE,
    preset: str = PRESET,
    calibration: Path = CALIBRATION,
) -> None:
    """Bathe a simulated person: see, correct, locate, approach, scrub, retract, go home.

    Starts every node as a process of its own on an isolated DDS domain, and ends them all again.
    Writes run.mcap, summary.json, report.html and logs/. The exit code is 0 only if the job was done.

    \b
      bathbot demo
      bathbot demo --region upperlimb --seed 3 --scenario restless --out bathing/arm
      bathbot demo --preset good --calibration good.npz      after: simulate board, calibrate depth
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing.settings import DemoSettings
    from bathbot_bringup.bathing.steps import full_region_name
    from bathbot_bringup.demo import run_demo
    from bathbot_bringup.graph.installation import SIM_CALIBRATION

    folder = out or Path("bathing") / time.strftime("%Y%m%d-%H%M%S")
    name, calibration = full_region_name(region), calibration or SIM_CALIBRATION
    settings = DemoSettings(name, seed, scenario, folder, duration, rate, preset, calibration)
    raise typer.Exit(run_demo(settings))


def bathe(
    region: str = typer.Option("Trunk_skin", help="Region to bathe; trunk, upperlimb, ... will do."),
    duration: float = typer.Option(60.0, min=1.0, max=600.0, help="Longest time of scrubbing [s]."),
    yes: bool = typer.Option(False, "--yes", help="Do not ask before the arm moves."),
) -> None:
    """Bathe a region with the nodes that run on this machine: look, approach, scrub, retract, go home.

    The arm MOVES. Keep the emergency stop in your hand; Ctrl-C stops the arm as well. Not a medical device.

    \b
      ros2 launch bathbot_bringup robot.launch.py arm_host:=192.168.1.18 ...   in another terminal
      bathbot bathe --region upperlimb
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bathing.client_node import Bather
    from bathbot_bringup.bathing.job import BathingJob
    from bathbot_bringup.bathing.steps import full_region_name
    from bathbot_bringup.errors import StepError
    from bathbot_bringup.graph.client_node import GraphClient
    from bathbot_bringup.graph.stages import StageLog

    name = full_region_name(region)
    if not yes:
        typer.confirm(f"The arm will move to {name}. Is the emergency stop at hand?", abort=True)
    log = StageLog()
    try:
        with GraphClient("bathbot_bathe") as client:
            BathingJob(Bather(client, name), log, duration).run()
    except StepError as error:
        log.say(f"NOT DONE: {error}")
        raise typer.Exit(1) from error
