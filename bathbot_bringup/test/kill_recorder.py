"""The recorder's node killed with signal 9 at random moments: `python kill_recorder.py COUNT`.

Prints how many of the bags open as they lie, and how many messages they lack of those that were sent
more than a second before, after the first that was heard.
"""

import random
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

from bathbot_bringup.bag.reading import read_messages, summarise_bag
from bathbot_bringup.errors import BagError
from bathbot_bringup.graph.running import started

from bathbot_msgs.msg import ArmState

PERIOD, LAST = 0.005, 1.0  # [s]


def talk(publisher, sent, over):
    """Publish numbered states and note when."""
    while not over.wait(PERIOD):
        sent.append(time.time())
        publisher.publish(ArmState(path_id=len(sent) - 1))


def main(count):
    """Kill, look, print."""
    folder, rng = Path(tempfile.mkdtemp()), random.Random(7)
    opened = lacking = heard = 0
    with started({}, folder / "logs", "talker") as graph:
        for number in range(count):
            bag, sent, over = folder / f"bag{number}", [], threading.Event()
            # a topic of its own: the killed one before is still among its listeners
            states = graph.client.node.create_publisher(ArmState, f"run{number}/arm_state", 10)
            talker = threading.Thread(target=talk, args=(states, sent, over))
            talker.start()
            recorder = graph.start("recorder", {"bag": bag})
            assert graph.client.spin_until(lambda heard=states: heard.get_subscription_count() > 0, 30.0)
            time.sleep(rng.uniform(0.0, 4.0))
            recorder.process.send_signal(signal.SIGKILL)
            killed = time.time()
            recorder.process.wait()
            graph.group.children.remove(recorder)
            over.set()
            talker.join()
            try:
                summarise_bag(bag)
                found = [entry.message.path_id for entry in read_messages(bag, ("arm_state",))]
            except BagError as error:
                print(f"{number}: {error}")
                continue
            opened += 1
            if found:
                due = [place for place in range(found[0], len(sent)) if sent[place] < killed - LAST]
                lacking += len(set(due) - set(found))
                heard += len(found)
    print(f"{opened} of {count} open as they lie; they hold {heard} messages and lack {lacking}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
