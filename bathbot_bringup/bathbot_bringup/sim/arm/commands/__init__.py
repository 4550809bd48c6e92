"""The commands of the emulated controller, one file per subject; importing it fills the table."""

from bathbot_bringup.sim.arm.commands import (  # noqa: F401 - each enters its commands
    force,
    frames,
    information,
    limits,
    moves,
    push,
    settings,
    state,
    stream,
    teach,
)
