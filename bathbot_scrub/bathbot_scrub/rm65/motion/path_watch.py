"""Whether the rest of the way is still free: looked at whenever the camera has seen the body anew.

A way is checked when it is planned; a person may move into it afterwards. So every new cloud is held against
what is left of the motion, whether that is under way or waits to go on, and nothing goes on after a pause
without being looked at. A camera that has gone blind ends a way to the person. Looking takes some
milliseconds, in a thread of its own; the control loop's lock is held only to ask where the arm is, and to
stop it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import CollisionError, NotReadyError
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.paths.joint_path import JointPath
from bathbot_scrub.rm65.paths.path_runner import PathRunner
from bathbot_scrub.rm65.paths.surroundings import Body, Surroundings

Array = NDArray[np.float64]
LOOKS = 20.0  # [Hz]
# [m] less than a plan keeps: the cloud is not the same twice, the body breathes, and links are drawn as wide
_SLACK = 0.010
_TO_THE_PERSON = (MotionKind.TRANSIT, MotionKind.SEEK)
_EVERY = 0.01  # [m] or rad between places along a scrub path that the head may touch


class RestOfWay(NamedTuple):
    """What is left of a motion."""

    runner: PathRunner  # tells one motion from another
    kind: MotionKind
    path: JointPath
    length: float  # where the arm is on it
    patch: Array  # (K, 3) [m] places about which the head may touch the body


class PathWatch:
    """Watches the motion of one control loop."""

    def __init__(self, loop: ControlLoop, surroundings: Surroundings) -> None:
        """Watch `loop` among `surroundings`; `look` does it."""
        self._loop, self._surroundings = loop, surroundings
        self._runner: PathRunner | None = None  # of the motion that was looked at last,
        self._seen: Body | None = None  # and the cloud it was held against

    def look(self) -> None:
        """Stop the arm where the newest cloud shows somebody in the way; call it often.

        On the way to the person also where that cloud has become too old, or shows nobody any more.
        """
        way = self.rest()
        if way is None:
            return
        try:
            if way.kind in _TO_THE_PERSON:
                self._surroundings.trust()
            self._check_anew(way)
        except CollisionError as error:
            self._loop.give_up(way.runner, _said(error))
        except NotReadyError as error:
            self._loop.give_up(way.runner, str(error))

    def _check_anew(self, way: RestOfWay) -> None:
        """Check what is left of a way, unless it was held against the newest cloud already."""
        seen = self._surroundings.body
        if seen is not None and not (way.runner is self._runner and seen is self._seen):
            self._runner, self._seen = way.runner, seen
            self.check(way)

    def check_paused(self) -> None:
        """Look at the way on which a paused motion would go on.

        Raises:
            NotReadyError: Somebody has moved into it, or nobody knows where the body is.
        """
        way = self.rest()
        if way is not None and self._loop.guard.paused:
            self._surroundings.trust()
            try:
                self.check(way)
            except CollisionError as error:
                raise NotReadyError(_said(error)) from error

    def rest(self) -> RestOfWay | None:
        """What is left of the motion under way or paused; None where there is none, or where it leaves."""
        loop = self._loop
        with loop.lock:
            motion = loop.motion
            runner, kind, patch = motion.runner, motion.kind, motion.patch
            if runner is None or kind is MotionKind.LEAVE:
                return None
            return RestOfWay(runner, kind, runner.path, runner.length, patch)

    def check(self, way: RestOfWay) -> None:
        """Refuse what is left of a way on which something would be met now.

        Raises:
            CollisionError: With what is in the way, and where.
        """
        path, around = way.path, self._surroundings
        ahead = path.lengths > way.length
        if not ahead.any():
            return
        joints = np.concatenate([path.at(way.length)[None], path.joints[ahead]])
        margin, patch = around.margin, way.patch
        if way.kind is MotionKind.SCRUB:
            places = np.append(np.arange(0.0, path.end, _EVERY), path.end)
            margin, patch = around.scrub_margin, around.heads(np.stack([path.at(s) for s in places]))
        around.check_body(joints, patch, margin - _SLACK)


def _said(error: CollisionError) -> str:
    return f"the person has moved into the way: {error}"
