"""`bathbot bench detector`: how fast the detector is here, and what the node adds to the network."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros.messages import image_from_colour
from bathbot_perception.detection.detector import DEFAULT_MODEL, MODELS, Detector, load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.detection.smoothing import Smoothing
from bathbot_perception.messages import ImageDetection
from rich.console import Console
from rich.progress import track
from rich.table import Table

from bathbot_bringup.bag.message_types import message_class
from bathbot_bringup.bench.machine import machine, machine_words
from bathbot_bringup.errors import InputError
from bathbot_bringup.files import write_json
from bathbot_bringup.sim.render.render import render
from bathbot_bringup.sim.scene import BathroomScene

INT8 = MODELS / "skin_int8.onnx"
_CAMERA = (848, 480)  # width and height of the colour stream [px]
_FOCAL = 0.5  # [image widths], about a D455's
_BLOCK, _WARM = 10, 2  # pictures of one model before the other's turn; those before them do not count


class DetectorBench(NamedTuple):
    """What to measure."""

    rounds: int = 150
    threads: int = 2
    size: int = 0  # longer side of the input [px]; 0: as the models say
    seed: int = 0  # of the simulated person


class Times(NamedTuple):
    """Medians of one model [ms]."""

    node: float  # message in, message out
    runtime: float  # the bare call of ONNX Runtime


def bench_detector(bench: DetectorBench, json_file: Path | None) -> None:
    """Time both models, each with and without the node's work, in turns; print a table, write the numbers.

    Raises:
        InputError: On fewer rounds than a median needs.
        PerceptionError: On a model or size that cannot be used.
    """
    if bench.rounds < 10:
        raise InputError(f"rounds must be 10 or more, got {bench.rounds}")
    console, here, image = Console(highlight=False), machine(), bench_image(bench.seed)
    settings = SkinDetectorSettings(threads=bench.threads, size=bench.size)
    detectors = {name: load(file, settings) for name, file in (("fp32", DEFAULT_MODEL), ("int8", INT8))}
    times = time_detectors(detectors, image, bench.rounds, console)
    fit = detectors["int8"].fit((image.height, image.width))
    numbers = {
        "fps": 1e3 / times["int8"].node,
        "fps_fp32": 1e3 / times["fp32"].node,
        "node_over_runtime": max(one.node / one.runtime for one in times.values()),
        "int8_over_fp32": times["fp32"].runtime / times["int8"].runtime,
        "size_px": detectors["int8"].size,
        "input": f"{fit.width}x{fit.height}",
        "threads": bench.threads,
        "models": {name: one._asdict() for name, one in times.items()},
        "machine": here,
    }
    _print(console, numbers)
    if json_file:
        write_json(json_file, numbers)


def bench_image(seed: int) -> Any:
    """A colour message (`Image`) of a simulated person, as the camera sends it."""
    scene, (width, height) = BathroomScene(seed), _CAMERA
    pinhole = Pinhole(width, height, _FOCAL * width, _FOCAL * width, 0.5 * width, 0.5 * height)
    rgb = np.ascontiguousarray(render(scene.stage(), pinhole, scene.T_base_camera).colour)
    return image_from_colour(rgb, message_class("std_msgs/msg/Header")())


def time_detectors(
    detectors: dict[str, Detector], image: Any, rounds: int, console: Console
) -> dict[str, Times]:
    """Medians over short blocks in which each model is alone, as in a node, and each has its turn.

    The first calls of a block do not count: the other model has the caches then.
    """
    calls: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
        name: _calls(detector, image) for name, detector in detectors.items()
    }
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in detectors}
    blocks = -(-rounds // _BLOCK)
    for _ in track(range(blocks), "pictures", console=console, transient=True):
        for name, (node, runtime) in calls.items():
            times = [(_timed(node), _timed(runtime)) for _ in range(_WARM + _BLOCK)]
            taken[name] += times[_WARM:]
    return {name: Times(*np.median(rows, axis=0).tolist()) for name, rows in taken.items()}


def _calls(detector: Detector, image: Any) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """The node's work on an image, and the bare call of the runtime on the same."""
    detection = ImageDetection(detector, Smoothing(0.0))
    rgb = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    return lambda: detection.detect(image), detector.bare(rgb)


def _timed(call: Callable[[], Any]) -> float:
    """Duration [ms]."""
    begun = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - begun)


def _print(console: Console, numbers: dict[str, Any]) -> None:
    table = Table(
        "model", "node [ms]", "ONNX Runtime alone [ms]", "node over runtime", "pictures/s",
        title=f"skin detector, {numbers['size_px']} px, {numbers['threads']} threads", title_justify="left",
        caption=machine_words(numbers["machine"]),
    )  # fmt: skip
    for name, one in numbers["models"].items():
        ratio, rate = one["node"] / one["runtime"], 1e3 / one["node"]
        table.add_row(name, f"{one['node']:.1f}", f"{one['runtime']:.1f}", f"{ratio:.2f}", f"{rate:.1f}")
    console.print(table)
    console.print(f"INT8 is {numbers['int8_over_fp32']:.2f} times as fast as fp32.")
