"""Damaged and lying bags thrown at every command that reads one: `python bad_bags.py FOLDER [NAME...]`.

Says of each what was wrong: a code that is neither 0 nor 2, more than one line, a traceback, a hang, a file
that a refusal left. What can be used may be used. NAMEs choose among the bags.
"""

import os
import random
import struct
import subprocess
import sys
from pathlib import Path

from bags import write_bag
from bathbot_bringup.bag.message_types import installed_types
from builtin_interfaces.msg import Time
from mcap.writer import Writer
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image

MAGIC = b"\x89MCAP0\r\n"
TICK = "builtin_interfaces/msg/Time"
COLOUR, DEPTH = "/camera/camera/color/image_raw", "/camera/camera/depth/image_rect_raw"
IMAGE, INFO, CLOCK = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo", "rosgraph_msgs/msg/Clock"
REGIONS = "vision_msgs/msg/Detection2DArray"
YEAR, PATIENCE = 365 * 86400 * 10**9, 60.0  # [ns], [s]
LOOK = 15.0  # [s] after which a node that found nothing wrong is ended
COMMANDS = {
    "replay": ("replay", "{bag}"),
    "detect": ("detect", "{bag}", "--out", "{out}"),
    "depth": ("calibrate", "depth", "{bag}", "--out", "{out}.npz"),
    "hand-eye": ("calibrate", "hand-eye", "{bag}", "--out", "{out}.yaml"),
    "repair": ("repair", "{bag}", "--out", "{out}"),
    "node": ("node", "replayer", "--ros-args", "-p", "bag:={bag}"),
}


def picture(width=64, height=48, encoding="rgb8", data=None):
    """A black one, or one whose fields do not fit each other."""
    size = width * height * (2 if encoding == "16UC1" else 3)
    step = width * (2 if encoding == "16UC1" else 3)
    return Image(
        width=width, height=height, encoding=encoding, step=step, data=bytes(size) if data is None else data
    )


def moments(times=range(10**18, 10**18 + 10**9, 10**8), colour=None):
    """Pictures of both kinds, camera information and a tick, at each time [ns]."""
    info = CameraInfo(width=64, height=48, k=[50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0])
    for time in times:
        yield COLOUR, IMAGE, time, colour or picture()
        yield DEPTH, IMAGE, time, picture(encoding="16UC1")
        yield COLOUR.replace("image_raw", "camera_info"), INFO, time, info
        yield DEPTH.replace("image_rect_raw", "camera_info"), INFO, time, info
        yield "/tick", TICK, time, Time(sec=1)


def written(file, channels, times=(1, 2, 3)):
    """A file of channels by topic, type, language, definition, encoding and data, all as they are given."""
    with file.open("wb") as opened:
        writer = Writer(opened)
        writer.start("ros2")
        for topic, kind, language, definition, encoding, data in channels:
            schema = writer.register_schema(kind, language, definition)
            channel = writer.register_channel(topic, encoding, schema)
            for time in times:
                writer.add_message(channel, time, data, time)
        writer.finish()


def text_of(kind):
    """Definition of an installed type."""
    return installed_types().generate_msgdef(kind, ros_version=2)[0].encode()


def flipped(file, seed, count=5):
    """Change bits anywhere."""
    data, rng = bytearray(file.read_bytes()), random.Random(seed)
    for _ in range(count):
        data[rng.randrange(8, len(data))] ^= 1 << rng.randrange(8)
    file.write_bytes(data)


def make_bags(folder):
    """Bags by their name; `whole` is as it should be."""
    folder.mkdir(parents=True)
    whole = write_bag(folder / "whole", list(moments()))
    data = (whole / "whole.mcap").read_bytes()
    good_image, tick = serialize_message(picture()), serialize_message(Time(sec=1))
    made, noise = {"whole": whole}, b"\0\1\0\0" + b"\xff" * 99

    def file(name, content):
        made[name] = folder / f"{name}.mcap"
        made[name].write_bytes(content)

    def channels(name, *rows, times=(1, 2, 3)):
        made[name] = folder / f"{name}.mcap"
        written(made[name], rows, times)

    def place(name, *files):
        made[name] = folder / name
        made[name].mkdir()
        for at, content in files:
            (made[name] / at).parent.mkdir(exist_ok=True)
            (made[name] / at).write_bytes(content)

    file("empty", b"")
    file("magic", MAGIC)
    file("two_magics", MAGIC + MAGIC)
    file("text", b"no bag at all\n" * 99)
    file("cut_half", data[: len(data) // 2])
    file("cut_footer", data[:-20])
    file("huge_record", MAGIC + struct.pack("<BQ", 6, 2**62) + bytes(99))
    file("zeros", MAGIC + bytes(9999))
    for seed in range(6):
        file(f"flipped_{seed}", data)
        flipped(made[f"flipped_{seed}"], seed)
    time_text = b"int32 sec\nuint32 nanosec"
    channels("schema_words", ("/t", TICK, "ros2msg", b"not a definition {{", "cdr", tick))
    channels("schema_bytes", ("/t", TICK, "ros2msg", b"\xff\xfe\x00", "cdr", tick))
    channels("schema_other", (COLOUR, IMAGE, "ros2msg", time_text, "cdr", tick))
    channels("schema_none", (COLOUR, IMAGE, "", b"", "cdr", good_image))
    channels("type_unknown", ("/t", "strange_msgs/msg/Thing", "ros2msg", time_text, "cdr", tick))
    channels("type_words", ("/t", "no type at all", "ros2msg", time_text, "cdr", tick))
    channels("name_words", ("no topic at all", TICK, "ros2msg", time_text, "cdr", tick))
    channels("schema_json", ("/t", TICK, "jsonschema", b"{}", "cdr", tick))
    channels("encoding_json", ("/t", TICK, "ros2msg", time_text, "json", b'{"sec": 1}'))
    channels("data_short", (COLOUR, IMAGE, "ros2msg", text_of(IMAGE), "cdr", good_image[:30]))
    channels("data_noise", (COLOUR, IMAGE, "ros2msg", text_of(IMAGE), "cdr", noise))
    channels("data_regions", ("/t", TICK, "ros2msg", time_text, "cdr", tick),
             ("/skin_regions", REGIONS, "ros2msg", text_of(REGIONS), "cdr", noise))  # fmt: skip
    channels("data_none", ("/t", TICK, "ros2msg", time_text, "cdr", b""))
    channels("twice_channel", *[("/t", TICK, "ros2msg", time_text, "cdr", tick)] * 2)
    channels("twice_type", ("/t", TICK, "ros2msg", time_text, "cdr", tick),
             ("/t", CLOCK, "ros2msg", b"int32 sec", "cdr", serialize_message(Clock())))  # fmt: skip
    channels("twice_time", ("/t", TICK, "ros2msg", time_text, "cdr", tick), times=(7,) * 50)
    channels("time_huge", ("/t", TICK, "ros2msg", time_text, "cdr", tick), times=(2**63, 2**64 - 1))
    day = [10**18, 10**18 + 10**8]
    made["jump_on"] = write_bag(folder / "jump_on", list(moments([*day, day[1] + YEAR])))
    made["jump_back"] = write_bag(folder / "jump_back", list(moments([*day, day[0] - YEAR])))
    lying = {"sizes": {"data": b"123"}, "encoding": {"encoding": "nonsense"}, "nothing": {"width": 0}}
    for name, fields in lying.items():
        made[f"picture_{name}"] = write_bag(
            folder / f"picture_{name}", list(moments(colour=picture(**fields)))
        )
    about = (whole / "metadata.yaml").read_bytes()
    place("folder_empty")
    place("folder_of_text", ("notes.txt", b"x"))
    place("metadata_only", ("metadata.yaml", about))
    place("metadata_words", ("metadata.yaml", b"{ no yaml"), ("whole.mcap", data))
    place("metadata_other", ("metadata.yaml", b"a: 1"), ("whole.mcap", data))
    place("metadata_none", ("whole.mcap", data))
    place("metadata_sqlite", ("metadata.yaml", about.replace(b'"mcap"', b'"sqlite3"')), ("whole.mcap", data))
    place("two_files", ("a.mcap", data), ("b.mcap", data))
    place("two_bags", ("a/metadata.yaml", about), ("a/whole.mcap", data), ("b/metadata.yaml", about),
          ("b/whole.mcap", data))  # fmt: skip
    place("two_in_one", ("metadata.yaml", about), ("whole.mcap", data), ("other.mcap", data))
    made["missing"] = folder / "missing"
    made["fifo"] = folder / "fifo.mcap"
    os.mkfifo(made["fifo"])
    made["device"] = folder / "device.mcap"
    made["device"].symlink_to("/dev/zero")
    made["loop"] = folder / "loop.mcap"
    made["loop"].symlink_to(made["loop"])
    return made


def throw(name, bag, command, out):
    """Run one command over one bag; gives code, lines on stderr, and what is wrong."""
    line = [word.format(bag=bag, out=out) for word in COMMANDS[command]]
    with subprocess.Popen(
        [sys.executable, "-m", "bathbot_bringup.command.cli", *line],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True,
    ) as process:  # fmt: skip
        for patience, end in (
            (LOOK if command == "node" else PATIENCE, process.terminate),
            (5.0, process.kill),
        ):
            try:
                process.wait(patience)
            except subprocess.TimeoutExpired:
                end()
        out_text, err_text = process.communicate()
    if process.returncode in (-9, 143):
        return "", [], ["HANGS"]
    said, wrong = [one for one in err_text.splitlines() if not one.startswith("[INFO]")], []
    if "Traceback" in out_text + err_text or any("[FATAL]" in one for one in said):
        wrong.append("TRACEBACK")
    if process.returncode not in (0, 2):
        wrong.append("CODE")
    if process.returncode == 2 and len(said) != 1:
        wrong.append("LINES")
    left = [path.name for path in out.parent.glob(f"*{out.name}*")]
    if process.returncode == 2 and left:
        wrong.append(f"LEFT {left}")
    return process.returncode, said, wrong


def main(folder, names):
    """Throw every bag at every command."""
    made, total = make_bags(folder / "bags"), 0
    for name, bag in made.items():
        for command in COMMANDS if not names or name in names else ():
            code, said, wrong = throw(name, bag, command, folder / f"{name}-{command}")
            total += bool(wrong)
            print(f"{name:16} {command:9} {code:>3} {' '.join(wrong):12} {said[-1:]}", flush=True)
    print(f"{total} went wrong")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
