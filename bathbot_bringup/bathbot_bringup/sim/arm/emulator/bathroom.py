"""The emulated arm in the simulated bathroom: its brush meets the skin of one moving person."""

import gc
import logging
import threading
import time

from bathbot_scrub.rm65.timing.priority import prefer_process

from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.node_settings import SimRm65Settings
from bathbot_bringup.sim.arm.emulator.surface import NoSurface
from bathbot_bringup.sim.brush import SkinSurface

log = logging.getLogger(__name__)


def prefer_the_arm() -> None:
    """Set up this process for the clocked thread; what it starts later takes after it."""
    prefer_process()


def bathroom_emulator(settings: SimRm65Settings) -> Emulator:
    """Start the emulator beside the person of the settings' seed.

    Raises:
        BathbotError: On a bad scenario, or a port that is taken.
    """
    scenario = settings.motion()
    surface: SkinSurface = NoSurface()
    if settings.person:
        from bathbot_bringup.sim.scene import BathroomScene  # takes a second to load

        surface = BathroomScene(settings.seed).surface(scenario)
    epoch = settings.epoch or time.time()
    # What is loaded by now stays. A full collection over it would hold up the arm for 0.07 s and more.
    gc.collect()
    gc.freeze()
    emulator = Emulator(settings.emulator(), surface, lambda: time.time() - epoch)
    for fault in scenario.faults:
        emulator.order(fault)
    return emulator


def run(settings: SimRm65Settings) -> None:
    """Run without ROS until interrupted; the trace is written at the end.

    Raises:
        BathbotError: On a bad scenario, a port that is taken, or a trace that cannot be written.
    """
    with bathroom_emulator(settings) as emulator:
        prefer_the_arm()  # its own threads have asked for more already
        log.info(
            "RM65-%s, generation %d: TCP %s:%d, state push to UDP port %d of whoever connects; Ctrl-C ends",
            settings.variant,
            settings.generation,
            settings.host,
            emulator.port,
            settings.udp_port,
        )
        try:
            threading.Event().wait()
        finally:
            emulator.close()
            log.info("ended: %d states pushed, %d steps late, %d frames refused",
                     emulator.pushed, emulator.late, emulator.refused)  # fmt: skip
            if settings.trace:
                emulator.trace.write(settings.trace)
                log.info("trace written to %s", settings.trace)
