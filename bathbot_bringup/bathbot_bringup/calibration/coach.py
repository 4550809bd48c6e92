"""The calibration coach: what it shows - goals, what the camera sees, what to do next - and its loop."""

import select
import sys
import time
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.calibration.coverage import (
    CORNERS,
    DISTANCES,
    TILTS,
    WANTED,
    ViewPose,
    coverage_of,
    instruction,
)
from bathbot_depthcorr.calibration.guards import BOARD_DEMANDS, GOOD_VIEWS
from bathbot_depthcorr.calibration.live_views import LiveViews
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

_GLANCE = 0.3  # [s] between two looks while the camera moves


class CoachState(NamedTuple):
    """What there is to show.

    Attributes:
        poses: Of the views taken.
        present: Where the camera is; None without the board.
        event: What happened last.
    """

    poses: tuple[ViewPose, ...] = ()
    present: ViewPose | None = None
    event: str = "looking for the board"


def pose_words(pose: ViewPose | None) -> str:
    """A pose in words: distance and turns."""
    if pose is None:
        return "no board in view"
    words = [f"{pose.distance:.2f} m"]
    for angle, (positive, negative) in ((pose.left, TILTS[:2]), (pose.up, TILTS[2:])):
        words.append(f"{abs(np.rad2deg(angle)):.0f} deg {positive if angle >= 0.0 else negative}")
    return ", ".join(words)


def render(state: CoachState) -> Group:
    """The whole screen."""
    coverage = coverage_of(state.poses)
    table = Table.grid(padding=(0, 2))
    for title, goals in (("distance", DISTANCES), ("turned", TILTS), ("wall in corner", CORNERS)):
        cells = Text()
        for goal in goals:
            have, want = min(coverage.counts[goal], WANTED[goal]), WANTED[goal]
            cells.append(
                f"{goal} {'■' * have}{'□' * (want - have)}   ", style="green" if have == want else "yellow"
            )
        table.add_row(title, cells)
    least = BOARD_DEMANDS.views
    lines = [
        Text(f"{len(state.poses)} views, {coverage.share:.0%} of the goals", style="bold"),
        table,
        Text(f"now: {pose_words(state.present)}"),
        Text(f"last: {state.event}"),
        Text(f"next: {instruction(state.poses, state.present)}", style="bold cyan"),
        Text(f"Enter or Ctrl-C: calibrate with what is there (from {least} views on)", style="dim"),
    ]
    return Group(*lines)


class CoachScreen:
    """Shows the state on a terminal; in a log file, one line per event. A context manager."""

    def __init__(self, console: Console | None = None) -> None:
        """Begin with nothing seen."""
        self._console = console or Console(highlight=False)
        self._told = ""
        self._live = Live(render(CoachState()), console=self._console, auto_refresh=False)

    def __enter__(self) -> "CoachScreen":
        """Begin to draw."""
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the last state on the terminal."""
        if self._console.is_terminal:
            self._live.stop()

    def show(self, state: CoachState) -> None:
        """Draw a state."""
        if self._console.is_terminal:
            self._live.update(render(state), refresh=True)
        elif state.event != self._told:
            following = instruction(state.poses, state.present)
            line = f"{state.event} ({pose_words(state.present)}); next: {following}"
            self._console.print(line, markup=False, soft_wrap=True)
            self._told = state.event


class CoachLoop:
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
