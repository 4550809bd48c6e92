"""The work of the calibration coach between two rounds of callbacks: look, show, listen for Enter."""

import select
import sys
import time

from bathbot_depthcorr.calibration_coverage import coverage_of
from bathbot_depthcorr.guards import BOARD_DEMANDS, GOOD_VIEWS
from bathbot_depthcorr.live_views import LiveViews

from bathbot_bringup.coach_screen import CoachScreen, CoachState

_GLANCE = 0.3  # [s] between two looks while the camera moves


class Gathering:
    """Looks at still moments, and at where the camera is in between, and shows what came of it."""

    def __init__(self, views: LiveViews, screen: CoachScreen) -> None:
        """Begin.

        Args:
            views: Fed by the camera.
            screen: Shows the state.
        """
        self.views, self._screen = views, screen
        self._state, self._next_glance, self._enough = CoachState(), 0.0, False

    def done(self) -> bool:
        """Whether there is nothing left to gather, or the user has enough."""
        poses = self.views.poses
        return self._enough or (len(poses) >= GOOD_VIEWS and not coverage_of(poses).missing)

    def work(self) -> None:
        """Take a still moment, or glance at where the camera is."""
        moment = self.views.still_moment()
        if moment is not None:
            look = self.views.take(moment)
            self._state = CoachState(tuple(self.views.poses), look.pose, look.words)
        elif time.monotonic() > self._next_glance:
            self._state = self._state._replace(present=self.views.glance())
        else:
            return
        self._hear_enter()
        self._screen.show(self._state)
        self._next_glance = time.monotonic() + _GLANCE

    def _hear_enter(self) -> None:
        if not (sys.stdin.isatty() and select.select([sys.stdin], [], [], 0.0)[0]):
            return
        sys.stdin.readline()
        self._enough = len(self.views.poses) >= BOARD_DEMANDS.views
        if not self._enough:
            told = f"{len(self.views.poses)} views are too few, {BOARD_DEMANDS.views} are needed"
            self._state = self._state._replace(event=told)
