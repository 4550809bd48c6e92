"""The pipeline over a recorded bag: which nodes run, and what came out."""

import os
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from bathbot_bringup.domain import free_domain, used_ports
from bathbot_bringup.errors import InputError, ProcessError
from bathbot_bringup.log_folder import log_folder
from bathbot_bringup.node_table import find_node, node_command
from bathbot_bringup.processes import ProcessGroup, isolated_environment
from bathbot_bringup.recorder import refuse_existing
from bathbot_bringup.replayer import ReplayTopic, choose_topics, has_pictures
from bathbot_bringup.share import SIM_CALIBRATION, SIM_HAND_EYE, config_file

PIPELINE = ("depth_corrector", "skin_detector", "target_localizer")
_START, _SLACK = 60.0, 60.0  # [s] until all nodes are active; beyond the length of the bag


@dataclass(frozen=True, slots=True)
class ReplaySettings:
    """What `bathbot replay` was asked to do."""

    bag: Path
    rate: float
    out: Path | None
    calibration: str
    hand_eye: str

    def __post_init__(self) -> None:
        """Refuse files that are not there.

        Raises:
            InputError: Names the file.
        """
        for file in filter(None, (self.calibration, self.hand_eye)):
            if not Path(file).is_file():
                raise InputError(f"there is no calibration {file}; `bathbot calibrate` makes one")
        if self.out is not None:
            refuse_existing(self.out)

    def parameters(self, node: str) -> dict[str, object]:
        """Parameters of one node of the replay."""
        depth = self.calibration or SIM_CALIBRATION
        hand_eye = self.hand_eye or config_file("bathbot_bringup", SIM_HAND_EYE)
        return {
            "depth_corrector": {"calibration": depth, "use_sim_time": True},
            "skin_detector": {"use_sim_time": True},
            "target_localizer": {"hand_eye": hand_eye, "use_sim_time": True},
            "recorder": {"bag": self.out.absolute() if self.out else ""},
            "replayer": {"bag": self.bag.absolute(), "rate": self.rate},
        }[node]


def replay_bag(settings: ReplaySettings, console: Console | None = None) -> dict[str, int]:
    """Replay a bag and count what comes out.

    Args:
        settings: What and how.
        console: To print to.

    Returns:
        Number of messages seen by topic.

    Raises:
        BringupError: When the bag cannot be used or a node fails.
    """
    console = console or Console(highlight=False)
    topics = choose_topics(settings.bag, sources_only=True)
    again = has_pictures([topic.name for topic in topics])
    if not again:
        console.print(
            f"{settings.bag} holds no pictures (the default privacy profile records none), so nothing can be "
            "detected again; what it holds is published and counted",
            markup=False,
            soft_wrap=True,
        )
    nodes = [*(PIPELINE if again else ()), *(("recorder",) if settings.out else ())]
    from bathbot_bringup.replay_watch_node import watch_replay  # ROS only once the bag is known to be good

    domain = free_domain(os.getpid(), used_ports())
    with log_folder("replay") as logs, ProcessGroup(logs, isolated_environment(domain, logs)) as group:
        for name in nodes:
            entry = find_node(name)
            group.start(name, node_command(entry, settings.parameters(name)), entry.niceness)
        counts, complaints = watch_replay(group, domain, settings, topics, _START, _SLACK)
    _print_outcome(console, topics, counts, complaints, again)
    return counts


def _print_outcome(
    console: Console,
    topics: list[ReplayTopic],
    counts: dict[str, int],
    complaints: dict[str, str],
    again: bool,
) -> None:
    replayed = sum(topic.messages for topic in topics)
    console.print(f"replayed {replayed} messages of {len(topics)} topics; heard:", markup=False)
    for name, count in sorted(counts.items()):
        console.print(f"{count:8d}  {name}", markup=False)
    if again:
        for node, message in sorted(complaints.items()):
            if node in PIPELINE and message:
                console.print(f"{node}: {message}", markup=False, soft_wrap=True)


def start_replayer(group: ProcessGroup, settings: ReplaySettings) -> None:
    """Start the node that publishes, once the others listen."""
    entry = find_node("replayer")
    group.start(entry.name, node_command(entry, settings.parameters("replayer")), entry.niceness)


def late(seconds: float) -> ProcessError:
    """The error of a replay that does not end."""
    return ProcessError("replayer", f"did not finish within {seconds:.0f} s", "", "the nodes' logs")
