"""`bathbot keys`: who may join the graph over a network."""

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from bathbot_bringup.graph.keys.keystore import Keystore
    from bathbot_bringup.graph.keys.rights import Enclave


def keys(
    folder: Path = typer.Argument(..., help="Folder to make for the keys; new or empty."),
    domain: list[int] = typer.Option(
        [0], min=0, max=232, envvar="ROS_DOMAIN_ID", help="DDS domain that the keys are for, once or more."
    ),
    days: int = typer.Option(365, min=1, max=3650, help="How long the keys are good for [days]."),
) -> None:
    """Make keys of SROS2, which BATHBOT_REACH=network demands, for the robot and for watchers.

    The robot's key is for all our nodes and commands; a watcher's hears what the privacy profile metrics_only
    records, and commands nothing. They need a Fast DDS that was built with security: docs/privacy.md.

    \b
      bathbot keys keystore
      bathbot keys keystore --domain 7 --days 90
    """  # noqa: D301 - \b keeps the lines of examples
    from bathbot_bringup.bag.recording.privacy import find_profile
    from bathbot_bringup.graph.installation import config_file
    from bathbot_bringup.graph.keys.keystore import make_keystore
    from bathbot_bringup.graph.keys.rights import robot, watcher

    profile = find_profile(config_file("bathbot_bringup", "privacy_profiles.yaml"), "metrics_only")
    enclaves = (robot(), watcher(entry.pattern for entry in profile.entries))
    typer.echo("\n".join(_told(make_keystore(folder, enclaves, domain, days), enclaves, domain)))


def _told(made: "Keystore", enclaves: Sequence["Enclave"], domains: Sequence[int]) -> Iterator[str]:
    """What to do with the keys, and what they open."""
    from bathbot_depthcorr.node.dds import reach

    folder = shlex.quote(str(made.folder))
    yield f"made {made.folder}; its keys end on {made.end:%Y-%m-%d %H:%M} UTC, make new ones before"
    yield "\nOn a machine of the robot, in every shell that starts a node or a command:"
    for name, value in reach.network_variables(made.folder, enclaves[0].name).items():
        yield f"  export {name}={shlex.quote(value)}"
    yield f"  export ROS_DOMAIN_ID={domains[0]}"
    yield f"\nOn a machine that only looks on, the same but {reach.ENCLAVE}={enclaves[1].name}.\n"
    for enclave in enclaves:
        yield f"{enclave.name} {enclave.about}"
    yield "no key: sees that machines talk, how much, and the names of these two; not what they say"
    yield "\nCopy to each machine what its programs need, and nothing else:"
    for enclave in enclaves:
        parts = f"public enclaves/governance.xml enclaves/governance.p7s enclaves{enclave.name}"
        yield f"  tar -C {folder} -c {parts} | ssh MACHINE 'mkdir -m 700 keys && tar -C keys -x'"
    yield f"Never copy {made.folder}/private: whoever has it makes keys of his own. Keep it off the network,"
    yield "or delete it when no more keys are to be signed."
