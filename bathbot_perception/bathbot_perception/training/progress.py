"""How far a training run is, for who watches it and for who reads its log."""

import csv
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn


class RowLog:
    """A CSV file that grows by rows; its columns are fixed by the first one."""

    def __init__(self, path: Path) -> None:
        """Append to `path`."""
        self.path = path

    def add(self, row: dict[str, object]) -> None:
        """Write one row, and the header into an empty file."""
        fresh = not self.path.exists() or self.path.stat().st_size == 0
        with self.path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(row))
            if fresh:
                writer.writeheader()
            writer.writerow(row)


class TrainingProgress:
    """A bar with images per second on a terminal, lines elsewhere; a context manager."""

    def __init__(self, budget: float, console: Console | None = None) -> None:
        """Begin before the first step; `budget` in [s] of training."""
        self._console = console or Console(highlight=False, soft_wrap=True)
        columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
        self._bar = Progress(*columns, console=self._console)
        self._task = self._bar.add_task("begins", total=budget)

    def __enter__(self) -> "TrainingProgress":
        """Show it."""
        if self._console.is_terminal:
            self._bar.start()
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Leave the last state on the screen."""
        if self._console.is_terminal:
            self._bar.stop()

    def say(self, line: str) -> None:
        """One line, above the bar."""
        self._console.print(line, markup=False)

    def tell(self, row: Mapping[str, float], seconds: float) -> None:
        """Take a row of training.csv after so many seconds of training."""
        line = (
            f"step {row['step']}  {row['images_per_s']} images/s  box {row['box']:.4f}  "
            f"objectness {row['objectness']:.4f}  class {row['class']:.4f}"
        )
        self._bar.update(self._task, description=line, completed=seconds)
        if not self._console.is_terminal:
            self.say(f"{row['minutes']:.1f} min  {line}")
