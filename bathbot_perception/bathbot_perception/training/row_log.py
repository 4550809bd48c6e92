"""Numbers of a run as rows of a CSV file."""

import csv
from pathlib import Path


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
