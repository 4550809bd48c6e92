"""The emulated arm in the simulated bathroom: its brush meets the skin of one moving person."""

import logging
import threading
import time

from bathbot_bringup.sim.emulator import Emulator
from bathbot_bringup.sim.emulator_surface import NoSurface
from bathbot_bringup.sim.scene import BathroomScene
from bathbot_bringup.sim.sim_rm65_settings import SimRm65Settings

log = logging.getLogger(__name__)


def bathroom_emulator(settings: SimRm65Settings) -> Emulator:
    """Start the emulator beside the person of the settings' seed.

    Raises:
        BathbotError: On a bad scenario, or a port that is taken.
    """
    surface = BathroomScene(settings.seed).surface(settings.motion()) if settings.person else NoSurface()
    epoch = settings.epoch or time.time()
    emulator = Emulator(settings.emulator(), surface, lambda: time.time() - epoch)
    for fault in settings.motion().faults:
        emulator.order(fault)
    return emulator


def run(settings: SimRm65Settings) -> None:
    """Run without ROS until interrupted."""
    with bathroom_emulator(settings) as emulator:
        log.info("RM65-%s emulator listens on %s:%d", settings.variant, settings.host, emulator.port)
        threading.Event().wait()
