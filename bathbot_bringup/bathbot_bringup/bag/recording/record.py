"""Recording from the command line: the recorder node as a child, until Ctrl-C or a time."""

import json
import time
from contextlib import suppress
from pathlib import Path

from bathbot_bringup.bag.reading import TopicSummary, notes_of, summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import refuse_existing
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
        BringupError: On a bad argument, when the recorder dies, or when nothing comes to count from.
    """
    find_profile(config_file("bathbot_bringup", "privacy_profiles.yaml"), profile).check_consent(consent)
    refuse_existing(out)
    parameters = {"bag": out.absolute(), "profile": profile, **consent._asdict()}
    with log_folder("record") as logs, ProcessGroup(logs, node_environment(logs)) as group:
        group.start("recorder", node_command(find_node("recorder"), parameters))
        try:
            _wait(group, out, seconds, patience)
        except KeyboardInterrupt:
            if seconds:
                raise
    return summarise_bag(out), notes_of(out)


def _wait(group: ProcessGroup, out: Path, seconds: float, patience: float) -> None:
    deadline, begun = time.monotonic() + patience, 0.0
    while not (seconds and begun and time.monotonic() > begun + seconds):
        group.check()
        if seconds and not begun and _messages(out):
            begun = time.monotonic()
        if seconds and not begun and time.monotonic() > deadline:
            raise BagError(
                f"nothing that the profile lets through came within {patience:.0f} s, so {out} is empty; are "
                "nodes running in this ROS_DOMAIN_ID?"
            )
        time.sleep(_LOOK)


def _messages(out: Path) -> int:
    """Messages of others in a bag that is being written, as of the last half second."""
    described = (out.parent if out.suffix == ".mcap" else out) / "metadata.yaml"
    with suppress(OSError, ValueError):  # it is about to appear
        about = json.loads(described.read_text(encoding="utf-8"))  # our YAML is JSON, too
        topics = about["rosbag2_bagfile_information"]["topics_with_message_count"]
        return sum(one["message_count"] for one in topics if one["topic_metadata"]["name"] not in _ITS_OWN)
    return 0
