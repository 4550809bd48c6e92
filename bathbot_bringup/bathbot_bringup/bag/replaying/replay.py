"""The pipeline over a recorded bag: which nodes run, and what came out."""

from rich.console import Console

from bathbot_bringup.bag.reading import bag_bytes, bag_length, check_whole
from bathbot_bringup.bag.replaying.replay_settings import ReplaySettings
from bathbot_bringup.bag.replaying.replayer import ReplayTopic, choose_topics, has_pictures, lost
from bathbot_bringup.errors import ProcessError, ReplayError
from bathbot_bringup.files import log_folder
from bathbot_bringup.graph.running import RunningGraph, running

PIPELINE = ("depth_corrector", "skin_detector", "target_localizer")
_SLACK = 60.0  # [s] beyond the length of the bag
_LOOKED_THROUGH = 50e6  # [bytes/s] of a bag that the replayer looks through first, at least
_LAST_WORDS = 2.0  # [s] for what is still being worked on


def replay_bag(settings: ReplaySettings, console: Console | None = None) -> dict[str, int]:
    """Replay a bag and count what comes out.

    Args:
        settings: What and how.
        console: To print to.

    Returns:
        Number of messages seen by topic.

    Raises:
        ReplayError: When messages were lost on the way.
        BringupError: When the bag cannot be used or a node fails.
    """
    console = console or Console(highlight=False)
    check_whole(settings.bag)
    topics = choose_topics(settings.bag, sources_only=True)
    again = has_pictures([topic.name for topic in topics])
    if not again:
        console.print(
            f"{settings.bag} holds no pictures (profile metrics_only records none), so nothing can be "
            "detected again; what it holds is published and counted",
            markup=False,
            soft_wrap=True,
        )
    nodes = [*(PIPELINE if again else ()), *(("recorder",) if settings.out else ())]
    with (
        log_folder("replay") as logs,
        running({name: settings.parameters(name) for name in nodes}, logs, "bathbot_replay") as graph,
    ):
        counts, complaints = watch_replay(graph, settings, topics)
    _print_outcome(console, topics, counts, complaints, again)
    if lacking := lost(topics, counts):
        names = ", ".join(f"{number} of {name}" for name, number in sorted(lacking.items()))
        raise ReplayError(
            f"{sum(lacking.values())} messages were lost on the way ({names}); a lower --rate or a quieter "
            "machine may help"
        )
    return counts


def watch_replay(
    graph: RunningGraph, settings: ReplaySettings, topics: list[ReplayTopic]
) -> tuple[dict[str, int], dict[str, str]]:
    """Start the replayer, which publishes once somebody listens, and count until it has finished.

    Args:
        graph: The pipeline.
        settings: Of the replay.
        topics: What will be published.

    Returns:
        Messages by topic, and what the nodes last complained about, by node.

    Raises:
        ProcessError: When a process dies or the replay does not end.
        ReplayError: When the replayer cannot go on.
    """
    from bathbot_bringup.bag.replaying.replay_watch_node import ReplayCounter  # ROS only once a graph runs

    counter = ReplayCounter(graph.client.node, topics)
    graph.start("replayer", settings.parameters("replayer"))
    patience = bag_length(settings.bag) / settings.rate + bag_bytes(settings.bag) / _LOOKED_THROUGH + _SLACK
    if not graph.client.spin_until(lambda: counter.finished or counter.broken, patience):
        raise ProcessError("replayer", f"did not finish within {patience:.0f} s", "", "the nodes' logs")
    if counter.broken:
        raise ReplayError(counter.broken)
    graph.client.wait(_LAST_WORDS)
    return dict(counter.counts), counter.complaints


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
