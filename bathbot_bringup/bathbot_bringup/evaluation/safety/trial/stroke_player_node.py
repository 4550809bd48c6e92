"""A planner of its own process that may be killed: plays one stroke as soon as the arm rests in contact."""

import signal
import sys
import threading
from pathlib import Path

import numpy as np
from bathbot_scrub.arm.states import State

from bathbot_bringup.evaluation.safety.trial.operator_node import Operator
from bathbot_bringup.evaluation.safety.trial.stroke_player import StrokePlayer
from bathbot_bringup.evaluation.safety.trial_plan import REGION
from bathbot_bringup.graph.client_node import GraphClient

_SETTLED = 0.3  # [s] in contact


def play(file: Path, ended: threading.Event) -> None:
    """Play the stroke of a file until `ended`."""
    with np.load(file) as stored:
        player = StrokePlayer(int(stored["path_id"]), REGION, stored["stroke"], float(stored["speed"]))
    with GraphClient("stroke_player") as client:
        operator = Operator(client)
        client.spin_until(lambda: ended.is_set() or operator.arm.state == State.CONTACT, float("inf"))
        client.spin_until(ended.is_set, _SETTLED)
        while not ended.is_set():
            segment = player.due(operator.arm.progress)
            if segment is not None:
                operator.send(segment)
            client.spin_until(ended.is_set, 0.01)


def main() -> None:
    """Run until a signal comes."""
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    play(Path(sys.argv[1]), ended)


if __name__ == "__main__":
    main()
