"""The joint stream beside the whole demo graph, timed where it arrives: at the emulated controller."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bathbot_bringup.bathing.client_node import Bather
from bathbot_bringup.bathing.nodes import demo_nodes
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bench.stroke_node import StrokeRepeater
from bathbot_bringup.errors import StepError
from bathbot_bringup.graph.isolation import free_ports
from bathbot_bringup.graph.running import running
from bathbot_bringup.sim.arm.sim_client_node import SimClient
from bathbot_bringup.sim.arm.trace import TraceData, load_trace

PERIOD = 0.01  # [s] of the stream
MISSED = 0.02  # [s] between two frames
_START = 100.0  # [s]
_ONCE = 0.4  # [m] of path planned once; afterwards it is washed to and fro


class ArmStream(NamedTuple):
    """How regular the stream was.

    Attributes:
        frames: Received by the controller.
        stream_missed: Gaps of more than 20 ms between two of them.
        stream_period_p99_dev_ms: 99th percentile of |period - 10 ms|.
        longest_period_ms: The longest gap.
        push_hz: Datagrams of state per second, by the controller's clock.
        protocol_errors: Frames that driver or controller refused.
        driver_missed: Periods of more than 20 ms between two frames sent, as the driver counts them.
    """

    frames: int
    stream_missed: int
    stream_period_p99_dev_ms: float
    longest_period_ms: float
    push_hz: float
    protocol_errors: int
    driver_missed: int


def regularity(trace: TraceData, protocol_errors: int, driver_missed: int) -> ArmStream:
    """Measure the stream of a trace throughout which the arm was told to move.

    Raises:
        StepError: When there is no stream in it.
    """
    gaps = np.diff(trace.frame_stamp)
    if len(gaps) < 2 or len(trace.stamp) < 2:
        raise StepError("bench", f"only {len(trace.frame_stamp)} frames of the joint stream came")
    pushed = int(np.isfinite(trace.pushed_force).sum())
    return ArmStream(
        frames=len(trace.frame_stamp),
        stream_missed=int((gaps > MISSED).sum()),
        stream_period_p99_dev_ms=float(1e3 * np.percentile(np.abs(gaps - PERIOD), 99)),
        longest_period_ms=float(1e3 * gaps.max()),
        push_hz=float(pushed / (trace.stamp[-1] - trace.stamp[0])),
        protocol_errors=protocol_errors,
        driver_missed=driver_missed,
    )


def watch_arm(seconds: float, folder: Path, progress: Callable[[float], object]) -> ArmStream:
    """Run the demo's graph, have it bathe, and keep the arm washing.

    Args:
        seconds: How long the stream is watched, from the contact on [s].
        folder: For bag, trace and logs.
        progress: Called all the while with the share that is done, 0..1.

    Raises:
        BringupError: When a node fails or the arm leaves the skin.
    """
    settings = DemoSettings("Trunk_skin", 0, "calm", folder)
    nodes = demo_nodes(settings, time.time(), free_ports(), folder / "bench.mcap")
    with running(nodes, folder, "bathbot_bench", _START) as graph:
        client = graph.client
        repeater, bather = StrokeRepeater(client), Bather(client, settings.region)
        sim = SimClient(client)
        bather.connect()
        bather.home()
        bather.select()
        bather.approach(bather.look(), lambda share, detail: None)
        sim.begin_trace()
        before, begun = counted(repeater), time.monotonic()
        bather.scrub(_ONCE, lambda share, detail: progress((time.monotonic() - begun) / seconds))

        def over() -> bool:
            repeater.step()
            progress((time.monotonic() - begun) / seconds)
            return time.monotonic() - begun > seconds

        client.spin_until(over, seconds + 60.0)
        trace = folder / "bench.npz"
        sim.write_trace(trace)
        errors, missed = np.subtract(counted(repeater), before)
        bather.retract()
    return regularity(load_trace(trace), int(errors), int(missed))


def counted(repeater: StrokeRepeater) -> tuple[int, int]:
    """Frames refused so far by driver and controller, and periods the driver has missed."""
    driver, controller = (repeater.diagnostics.get(name, {}) for name in ("rm65_driver", "sim_rm65"))
    errors = int(driver.get("protocol_errors", 0)) + int(controller.get("refused", 0))
    return errors, int(driver.get("periods_missed", 0))
