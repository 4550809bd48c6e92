"""Results of the detector's evaluation on the terminal."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

_BACKGROUND = "background"


@contextmanager
def counting(console: Console | None = None) -> Iterator[Callable[[int, int], None]]:
    """A progress bar over pictures; gives what to call with (done, in all)."""
    columns = TextColumn("pictures"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    console = console or Console()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("pictures", total=None)
        yield lambda done, count: bar.update(task, completed=done, total=count)


def print_detector(result: Mapping[str, Any], console: Console | None = None) -> None:
    """Print average precisions per class, what is taken for what, conditions, and the time per picture."""
    console = console or Console(highlight=False)
    table = Table(
        "class",
        "boxes",
        "AP50",
        title=f"{result['model']} on {result['images']} pictures",
        title_justify="left",
    )
    for name, precision in result["ap50"].items():
        table.add_row(name, str(result["boxes"][name]), _shown(precision))
    for key in ("map50", "map50_95"):
        table.add_row(key, "", _shown(result[key]))
    if result["difficult"]:
        table.add_row(
            "map50, difficult ones too", str(result["difficult"]), _shown(result["map50_with_difficult"])
        )
    table.add_row(
        "ms per picture", "", f"{result['ms_per_image_p50']} ({result['provider']}, {result['size_px']} px)"
    )
    console.print(table)
    console.print(_confusion_table(result))
    if result["conditions"]:
        console.print(_condition_table(result))


def _confusion_table(result: Mapping[str, Any]) -> Table:
    """True class down, found class across."""
    names = [*(name.removesuffix("_skin") for name in result["ap50"]), _BACKGROUND]
    table = Table("true \\ found", *names, title="what is taken for what", title_justify="left")
    for name, row in zip(names, result["confusion"], strict=True):
        table.add_row(name, *(str(count or "-") for count in row))
    return table


def _condition_table(result: Mapping[str, Any]) -> Table:
    table = Table("condition", "strength", "mAP50", "change", title="conditions", title_justify="left")
    clean = result["map50"]
    for name, strengths in result["conditions"].items():
        for strength, value in strengths.items():
            change = "-" if None in (value, clean) else f"{value - clean:+.3f}"
            table.add_row(name, strength, _shown(value), change)
        table.add_section()
    return table


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
