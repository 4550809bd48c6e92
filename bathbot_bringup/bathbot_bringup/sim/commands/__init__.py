"""The commands of the emulated controller, one file per subject; importing it fills the table."""

from bathbot_bringup.sim.commands import (  # noqa: F401 - each enters its commands
    force,
    frames,
    information,
    limits,
    moves,
    power,
    push,
    run,
    settings,
    state,
    steps,
    stream,
    teach,
)
