"""Recording from the command line: the recorder node as a child, until Ctrl-C or a time."""

import time
from pathlib import Path

from bathbot_bringup.bag.reading import TopicSummary, notes_of, summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import refuse_existing
from bathbot_bringup.bag.recording.privacy import Consent, find_profile
from bathbot_bringup.files import log_folder
from bathbot_bringup.graph.installation import config_file
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import ProcessGroup, node_environment


def record_graph(
    out: Path, profile: str, consent: Consent, seconds: float
) -> tuple[list[TopicSummary], dict[str, str]]:
    """Record what the graph of this environment publishes.

    Args:
        out: Bag to make.
        profile: Name of the privacy profile.
        consent: Who agreed, where the profile asks for it.
        seconds: How long [s]; 0 means until Ctrl-C.

    Returns:
        The topics in the bag, and its notes.

    Raises:
        BringupError: On a bad argument, or when the recorder dies.
    """
    find_profile(config_file("bathbot_bringup", "privacy_profiles.yaml"), profile).check_consent(consent)
    refuse_existing(out)
    parameters = {"bag": out.absolute(), "profile": profile, **consent._asdict()}
    deadline = time.monotonic() + (seconds or float("inf"))
    with log_folder("record") as logs, ProcessGroup(logs, node_environment(logs)) as group:
        group.start("recorder", node_command(find_node("recorder"), parameters))
        try:
            while time.monotonic() < deadline:
                group.check()
                time.sleep(0.1)
        except KeyboardInterrupt:
            if seconds:
                raise
    return summarise_bag(out), notes_of(out)
