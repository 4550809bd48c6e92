"""What all commands of planned motion share: whether the arm may move, and how a refusal is kept."""

from collections.abc import Callable

import numpy as np
from bathbot_scrub.arm.errors import ArmError, JointLimitError, ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer

from bathbot_bringup.sim.arm.commands.table import Desk
from bathbot_bringup.sim.arm.controller.arm_health import ARC_IMPOSSIBLE, TARGET_OVER_LIMIT, UNREACHABLE
from bathbot_bringup.sim.arm.controller.motion_plan import ArcError, Plan
from bathbot_bringup.sim.arm.controller.motion_queue import Ending, completion

_AWAY = 1e-3  # [rad] from where a motion was planned to begin


def check_ready(desk: Desk) -> None:
    """Refuse motion that cannot begin now.

    Raises:
        ProtocolError: Without power, in an emergency, with joints off, or while something else moves.
    """
    controller = desk.controller
    if not controller.health.ready:
        raise ProtocolError("the arm or a joint has no power, or an emergency stop holds it")
    if controller.halting:
        raise ProtocolError("the arm is about to stop")
    if controller.busy:
        raise ProtocolError("a planned motion is on its way")  # queue or replace: not published


def share_of(request: Frame) -> float:
    """Read the share of full speed, 0..1, from `v` in percent."""
    return integer(request, "v", 1, 100) / 100.0


def begin(
    desk: Desk,
    plan: Callable[[], Plan],
    more: bool = False,
    ending: Ending = completion,
    replaces: bool = False,
) -> None:
    """Plan a motion while the arm goes on, and begin it; remember why it cannot be done.

    Args:
        desk: Whose arm.
        plan: Plans it.
        more: Whether a connected piece follows.
        ending: Tells clients of the end.
        replaces: Whether it takes the place of the newest piece that waits.

    Raises:
        ArmError: When it cannot be planned.
        ProtocolError: When the arm may not move.
    """
    check_ready(desk)
    try:
        with desk.aside():
            planned = plan()
    except ArmError as error:
        desk.controller.health.error = _code(error)
        raise
    check_ready(desk)  # a fault may have come meanwhile
    if replaces:
        desk.controller.queue.take_back()
    first = (desk.controller.queue.waiting or [planned])[0]
    if np.abs(first.path.joints[0] - desk.controller.target).max() > _AWAY:
        desk.controller.queue.abandon()
        raise ProtocolError("the arm has moved since the first of the connected moves was accepted")
    desk.controller.begin(planned, more, ending)


def _code(error: ArmError) -> int:
    if isinstance(error, JointLimitError):
        return TARGET_OVER_LIMIT
    return ARC_IMPOSSIBLE if isinstance(error, ArcError) else UNREACHABLE
