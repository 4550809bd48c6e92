"""Stages of a job on the terminal: a moving bar for a person, plain lines for a log file."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn


class StageLog:
    """Shows stages one after the other.

    Attributes:
        console: Where it prints.
        times: How long each stage took, by its name [s].
    """

    def __init__(self, console: Console | None = None) -> None:
        """Begin to count time."""
        self.console = console or Console(highlight=False)
        self._begun = time.monotonic()
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        self.times: dict[str, float] = {}

    @property
    def elapsed(self) -> float:
        """Time since the beginning [s]."""
        return time.monotonic() - self._begun

    def say(self, text: str) -> None:
        """Print one line."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def note(self, text: str) -> None:
        """Print one line below the stage it belongs to."""
        self.say(f"{'':19}{text}")

    @contextmanager
    def stage(self, name: str, about: str) -> Iterator[None]:
        """Show a stage while it runs; one line remains, with its outcome and duration [s]."""
        begun = time.monotonic()
        outcome = "FAILED"
        try:
            with self._moving(about):
                yield
            outcome = "done"
        except KeyboardInterrupt:
            outcome = "stopped"
            raise
        finally:
            self.times[name] = round(time.monotonic() - begun, 2)
            self.say(f"{self.elapsed:7.1f} s  {outcome:7} {about} ({self.times[name]:.1f} s)")

    @contextmanager
    def _moving(self, about: str) -> Iterator[None]:
        if not self.console.is_terminal:
            yield
            return
        columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(24), TimeElapsedColumn())
        with Progress(
            *columns, TextColumn("{task.fields[detail]}"), console=self.console, transient=True
        ) as bar:
            self._bar, self._task = bar, bar.add_task(about, total=None, detail="")
            try:
                yield
            finally:
                self._bar = self._task = None

    def progress(self, fraction: float, detail: str) -> None:
        """Move the bar of the running stage: share done, 0..1, and a few words."""
        if self._bar is not None:
            total = 1.0 if fraction > 0.0 else None
            self._bar.update(self._task, completed=fraction, total=total, detail=detail)
