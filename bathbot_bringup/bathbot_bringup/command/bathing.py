"""`bathbot demo`, `bathe`, and a word each to the arm: `stop`, `pause`, `resume`, `retract`, `home`."""

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from bathbot_depthcorr.errors import BathbotError

from bathbot_bringup.command.arguments import CALIBRATION, PRESET, RATE, unused_folder

if TYPE_CHECKING:
    from bathbot_bringup.graph.client_node import GraphClient


def demo(
    region: str = typer.Option("Trunk_skin", help="Region to bathe; trunk, upperlimb, ... will do."),
    seed: int = typer.Option(0, help="Body, skin tone, pose, motion and noise follow from it."),
    scenario: str = typer.Option(
        "calm", help="How the person moves: still, calm, breathing, ... or a YAML file."
    ),
    out: Path = typer.Option(
        None, callback=unused_folder, help="Folder for the results, new; bathing/<date-time> if left out."
    ),
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
    from bathbot_bringup.graph.register import alone

    folder = out or Path("bathing") / time.strftime("%Y%m%d-%H%M%S")
    name, calibration = full_region_name(region), calibration or SIM_CALIBRATION
    settings = DemoSettings(name, seed, scenario, folder, duration, rate, preset, calibration)
    with alone():
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
    from bathbot_bringup.graph.register import alone
    from bathbot_bringup.graph.stages import StageLog

    name = full_region_name(region)
    if not yes:
        typer.confirm(f"The arm will move to {name}. Is the emergency stop at hand?", abort=True)
    log = StageLog()
    try:
        with alone(), GraphClient("bathbot_bathe") as client:
            BathingJob(Bather(client, name), log, duration).run()
    except StepError as error:
        log.say(f"NOT DONE: {error}")
        raise typer.Exit(1) from error


DOMAIN = typer.Option(
    None, min=0, max=232, help="DDS domain; left out: ROS_DOMAIN_ID, or that of the graph that runs here."
)
NAMESPACE = typer.Option("", help="Of the nodes, such as bath.")
_HEARD = 3.0  # [s] within which a node that runs is heard


def _client(domain: int | None) -> "GraphClient":
    from bathbot_bringup.graph.client_node import GraphClient  # ROS only once it is wanted
    from bathbot_bringup.graph.register import find_domain

    return GraphClient("bathbot", find_domain(domain))


def _call(verb: str, domain: int | None, namespace: str, timeout: float) -> None:
    with _client(domain) as client:
        service = "/".join(filter(None, (namespace.strip("/"), "arm", verb)))
        typer.echo(client.trigger(verb, service, timeout) or "done")


def stop(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Stop the arm where it is, at once. It stands until someone calls resume or retract.

    Where several graphs of this user run and none is named, all are stopped. This is no emergency stop.
    """
    from bathbot_bringup.graph.register import running_domains

    found = running_domains() if domain is None and "ROS_DOMAIN_ID" not in os.environ else []
    refusals = []
    for one in found or [domain]:
        try:
            _call("stop", one, namespace, _HEARD)
        except BathbotError as error:  # the next arm is to be stopped all the same
            refusals.append(error)
    if refusals:
        raise refusals[0]


def pause(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Stop the arm on its way; resume goes on from there."""
    _call("pause", domain, namespace, _HEARD)


def resume(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Go on after a pause; after a stop or a fault, allow the arm to move again.

    See first that head and way are free.
    """
    _call("resume", domain, namespace, 20.0)


def retract(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Take the head off the skin, straight back. The arm MOVES."""
    _call("retract", domain, namespace, _HEARD)


def home(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Fold the arm, off the skin only. The arm MOVES."""
    _call("home", domain, namespace, 60.0)


def status(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """Say what the arm does and what its nodes complain about."""
    from bathbot_bringup.graph.status_node import hear_status

    with _client(domain) as client:
        for line in hear_status(client, namespace, _HEARD):
            typer.echo(line)


def regions(domain: int = DOMAIN, namespace: str = NAMESPACE) -> None:
    """List the regions of bare skin that are seen now, and where the arm could touch them."""
    from bathbot_bringup.graph.status_node import hear_regions

    with _client(domain) as client:
        for line in hear_regions(client, namespace, _HEARD):
            typer.echo(line)
