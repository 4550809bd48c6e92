"""The pipeline over a recorded bag: which nodes run, and what came out."""

import os

from rich.console import Console

from bathbot_bringup.bag.replay_settings import ReplaySettings
from bathbot_bringup.bag.replayer import ReplayTopic, choose_topics, has_pictures
from bathbot_bringup.files import log_folder
from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import ProcessGroup, isolated_environment

PIPELINE = ("depth_corrector", "skin_detector", "target_localizer")
_START, _SLACK = 60.0, 60.0  # [s] until all nodes are active; beyond the length of the bag


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
    from bathbot_bringup.bag.replay_watch_node import (
        watch_replay,  # ROS only once the bag is known to be good
    )

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
