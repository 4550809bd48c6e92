"""The profile `full` beside the working demo: `python record_pictures.py SECONDS [FOLDER]`.

A D455's colour and depth pictures of 848x480 at 30 Hz, and all topics of the demo's graph, whose arm washes
all the while, go into one bag, 61 MB each second. Prints what was sent, what is in the bag, and the cost.
"""

import datetime
import re
import shutil
import sys
import tempfile
import time
from pathlib import Path

from bathbot_bringup.bag.reading import notes_of, summarise_bag
from bathbot_bringup.bathing.client_node import Bather
from bathbot_bringup.bathing.nodes import demo_nodes
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bench.stream import cpu_seconds
from bathbot_bringup.bench.stroke_node import StrokeRepeater
from bathbot_bringup.graph.isolation import free_ports
from bathbot_bringup.graph.running import running

SOURCE = """
import signal, sys, threading, time
import numpy as np
import rclpy
from bathbot_depthcorr.node.dds.participant_node import joining
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image
over = threading.Event()
signal.signal(signal.SIGINT, lambda *_: over.set())
rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
with joining():
    node = rclpy.create_node("pictures")
rng, streams = np.random.default_rng(0), {}
for name, depth, encoding in (("colour", 3, "rgb8"), ("depth", 2, "16UC1")):
    frames = [
        serialize_message(Image(
            height=480, width=848, step=848 * depth, encoding=encoding,
            data=rng.integers(0, 256, 848 * 480 * depth, dtype=np.uint8).tobytes(),
        ))
        for _ in range(3)
    ]
    streams[name] = node.create_publisher(Image, f"big/{name}", 10), frames
while any(publisher.get_subscription_count() == 0 for publisher, _ in streams.values()):
    time.sleep(0.05)
begun, sent = time.monotonic(), 0
while not over.is_set():
    for publisher, frames in streams.values():
        publisher.publish(frames[sent % 3])
    sent += 1
    over.wait(max(begun + sent / 30.0 - time.monotonic(), 0.0))
print("sent", sent, "in", time.monotonic() - begun, flush=True)
time.sleep(1.0)
"""


def main(seconds, folder):
    """Record and count."""
    bag = folder / "full.mcap"
    consent = {"who": "nobody", "when": str(datetime.date.today()), "why": "a measurement"}
    nodes = dict(demo_nodes(DemoSettings("Trunk_skin", 0, "calm", folder), time.time(), free_ports(), bag))
    nodes["recorder"] = {**nodes["recorder"], "profile": "full", **consent}
    with running(nodes, folder, "measure", 100.0) as graph:
        (recorder,) = (child for child in graph.group.children if child.name == "recorder")
        repeater, bather = StrokeRepeater(graph.client), Bather(graph.client, "Trunk_skin")
        bather.connect()
        bather.home()
        bather.select()
        bather.approach(bather.look(), lambda share, detail: None)
        bather.scrub(0.4, lambda share, detail: None)
        source = graph.group.start("pictures", [sys.executable, "-c", SOURCE])
        begun, cpu = time.monotonic(), cpu_seconds(recorder.process.pid)

        def over():
            repeater.step()
            return time.monotonic() - begun > seconds

        graph.client.spin_until(over, seconds + 60.0)
        cost = (cpu_seconds(recorder.process.pid) - cpu) / (time.monotonic() - begun)
        graph.group.children.remove(source)
        source.process.send_signal(2)
        source.process.wait(10.0)
        beat = bather.arm.period_deviation_p99
        bather.retract()
    sent, took = map(float, re.search(r"sent (\d+) in ([0-9.]+)", source.log.read_text()).groups())
    held = {topic.name: topic.messages for topic in summarise_bag(bag)}
    colour, depth = held.pop("/big/colour"), held.pop("/big/depth")
    print(
        f"{sent / took:.1f} Hz of each picture for {took:.0f} s: {sent:.0f} of each were sent; the bag has "
        f"{colour} and {depth}, and {sum(held.values())} other messages on {len(held)} topics\n"
        f"the recorder counts {notes_of(bag)['lost']} lost; it took {100 * cost:.0f} % of a core for "
        f"{bag.stat().st_size / 1e9:.2f} GB; the arm's beat was {1e3 * beat:.1f} ms off (p99)"
    )
    bag.unlink()


if __name__ == "__main__":
    place = Path(tempfile.mkdtemp(dir=sys.argv[2] if len(sys.argv) > 2 else None))
    try:
        main(float(sys.argv[1]), place)
    finally:
        shutil.rmtree(place)
