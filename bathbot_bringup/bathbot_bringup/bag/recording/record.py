"""Recording from the command line: the recorder node as a child, until Ctrl-C or a time."""

import time
from contextlib import suppress
from pathlib import Path

from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from bathbot_bringup.bag.reading import TopicSummary, explained, notes_of, summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import refuse_existing, remove_bag
from bathbot_bringup.bag.recording.privacy import Consent, find_profile
from bathbot_bringup.errors import BagError
from bathbot_bringup.files import log_folder
from bathbot_bringup.graph.installation import config_file
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import ProcessGroup, node_environment

_PATIENCE = 60.0  # [s] for the first message, where the end counts from it
_LOOK = 0.1  # [s]
_ITS_OWN = ("/rosout", "/diagnostics")  # topics on which the recorder itself speaks


def record_graph(
    out: Path, profile: str, consent: Consent, seconds: float, patience: float = _PATIENCE
) -> tuple[list[TopicSummary], dict[str, str]]:
    """Record what the graph of this environment publishes.

    Args:
        out: Bag to make.
        profile: Name of the privacy profile.
        consent: Who agreed, where the profile asks for it.
        seconds: How long, from the first message on [s]; 0 means until Ctrl-C.
        patience: For that message [s].

    Returns:
        The topics in the bag, and its notes.

    Raises:
        BringupError: On a bad argument, when the recorder dies, or when nothing comes to count from; then
            there is no bag.
    """
    find_profile(config_file("bathbot_bringup", "privacy_profiles.yaml"), profile).check_consent(consent)
    refuse_existing(out)
    parameters = {"bag": out.absolute(), "profile": profile, **consent._asdict()}
    with log_folder("record") as logs, ProcessGroup(logs, node_environment(logs)) as group:
        group.start("recorder", node_command(find_node("recorder"), parameters))
        try:
            came = _wait(group, out, seconds, patience)
        except KeyboardInterrupt:
            if seconds:
                raise
            came = True
    if not came:
        remove_bag(out)
        raise BagError(
            f"nothing that the profile {profile} lets through came within {patience:.0f} s, so there is no "
            f"{out}; are nodes running in this ROS_DOMAIN_ID?"
        )
    return summarise_bag(out), notes_of(out)


def _wait(group: ProcessGroup, out: Path, seconds: float, patience: float) -> bool:
    """Wait until all is recorded; false when there was nothing to count from."""
    deadline, begun = time.monotonic() + patience, 0.0
    while not (seconds and begun and time.monotonic() > begun + seconds):
        group.check()
        if seconds and not begun and _heard(out):
            begun = time.monotonic()
        if seconds and not begun and time.monotonic() > deadline:
            return False
        time.sleep(_LOOK)
    return True


def _heard(out: Path) -> bool:
    """Whether a bag that is being written holds a message of others, as of the last half second."""
    topics: dict[int, str] = {}
    file = out if out.suffix == ".mcap" else out / f"{out.name}.mcap"
    with suppress(BagError), explained(out), file.open("rb") as opened:  # it is about to appear, or to change
        for record in StreamReader(opened).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            if isinstance(record, Message) and topics.get(record.channel_id) not in _ITS_OWN:
                return True
    return False
