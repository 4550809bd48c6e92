"""`bathbot node`, `sim-arm`: run one part of the graph by itself; `clean`: what such programs left."""

import math
import os

import typer
from click import Context, HelpFormatter
from typer.core import TyperCommand

from bathbot_bringup.graph import node_table

_HELP = ("-h", "--help")


def node(
    context: typer.Context,
    name: str = typer.Argument("", help="Name of the node; leave it out to list them."),
) -> None:
    """Run one node with its YAML parameters, as `ros2 run` would.

    What stands after the name goes to the node:

    \b
      bathbot node                                          list the nodes
      bathbot node skin_detector                            run one
      bathbot node skin_detector --help                     its parameters, with units and ranges
      bathbot node sim_camera --ros-args -p seed:=3         with another parameter
    """  # noqa: D301 - \b keeps the lines of examples
    asked = [word for word in (name, *context.args) if word in _HELP]
    if name in _HELP:
        typer.echo(context.get_help())
        return
    if name and asked:
        typer.echo(_about(node_table.find_node(name)))
        return
    if not name:
        for entry in node_table.NODES.values():
            typer.echo(f"{entry.name:18}{entry.about}   ({entry.module})")
        return
    command = node_table.node_command(node_table.find_node(name))
    further = [argument for argument in context.args if argument != "--ros-args"]
    os.execv(command[0], [*command, *further])


def _about(entry: node_table.NodeEntry) -> str:
    """What a node is and what may be set: its parameter file has meaning, unit, range and default of each."""
    return (
        f"{entry.name}: {entry.about}\n\n"
        f"Set one parameter with --ros-args -p name:=value, or all by a copy of this and --params-file:\n\n"
        f"{entry.parameter_file.read_text(encoding='utf-8')}"
    )


def clean() -> None:
    """Remove what killed programs of bathbot have left: shared memory, and temporary folders a day old.

    Shared memory is also cleaned whenever a node starts; what a living program uses stays.
    """
    from bathbot_depthcorr.node.dds import shared_memory

    from bathbot_bringup.files import clean_folders

    megabytes, folders = shared_memory.clean() / 2**20, clean_folders()
    typer.echo(f"removed {megabytes:.1f} MB of shared memory and {folders} temporary folders")


class FaultHelp(TyperCommand):
    """A command whose help ends with the kinds of faults; what they do is loaded only then."""

    def format_epilog(self, context: Context, formatter: HelpFormatter) -> None:
        """Write the end of the help."""
        self.epilog = fault_kinds()
        super().format_epilog(context, formatter)


def fault_kinds() -> str:
    """The kinds of faults, for the end of the help."""
    from bathbot_bringup.sim.faults.kinds import KINDS

    lines = [f"  {name:18}{kind.about}" + ("" if math.isnan(kind.value) else f"; default {kind.value:g}")
             for name, kind in KINDS.items()]  # fmt: skip
    return "\b\nKinds of faults:\n" + "\n".join(lines)


def sim_arm(
    host: str = typer.Option("127.0.0.1", help="Address to listen on; the default hears only this machine."),
    port: int = typer.Option(
        8080, min=0, max=65535, help="TCP port of the JSON protocol; 0 takes a free one."
    ),
    udp_port: int = typer.Option(8089, min=1, max=65535, help="UDP port of the state that is pushed."),
    seed: int = typer.Option(0, help="Of the person the brush may touch."),
    generation: int = typer.Option(3, help="Of the controller: 3 or 4."),
    variant: str = typer.Option("6F", help="Of the arm: B, 6F or 6FB."),
    scenario: str = typer.Option(
        "calm", help="How the person moves and what fails: a name, or a YAML file with the keys below."
    ),
    person: bool = typer.Option(True, help="Whether somebody sits there."),
    trace: str = typer.Option("", help="File to write what really happened to at the end, .npz."),
) -> None:
    """Run the emulator of the RM65 controller alone, without ROS.

    Any client of the vendor's protocol may connect.

    \b
      bathbot sim-arm
      bathbot sim-arm --port 18080 --no-person --generation 4
      bathbot sim-arm --scenario faulty.yaml --trace run.npz

    A scenario file orders faults, and each is told when it begins and ends:

    \b
      faults:
        - {kind: lost_udp, after: 20.0, duration: 1.5}
        - {kind: body_push, after: 40.0, duration: 0.5, value: 0.1}
    """  # noqa: D301 - \b keeps the lines of examples
    import logging

    from bathbot_bringup.sim.arm.emulator.node_settings import SimRm65Settings

    logging.basicConfig(level=logging.INFO, format="%(message)s")
    settings = SimRm65Settings(
        host=host,
        port=port,
        udp_port=udp_port,
        variant=variant,
        generation=generation,
        seed=seed,
        scenario=scenario,
        person=person,
        trace=trace,
    )
    from bathbot_bringup.sim.arm.emulator.bathroom import run  # not before the settings are known to be good

    run(settings)
