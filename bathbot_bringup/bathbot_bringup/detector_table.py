"""Results of the detector's evaluation on the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table


def print_detector(result: Mapping[str, Any], console: Console | None = None) -> None:
    """Print average precisions per class, and the time per picture."""
    table = Table(
        "class",
        "boxes",
        "AP50",
        title=f"{result['model']} on {result['images']} pictures",
        title_justify="left",
    )
    for name, precision in result["ap50"].items():
        shown = "-" if precision is None else f"{precision:.3f}"
        table.add_row(name, str(result["boxes"][name]), shown)
    for key in ("map50", "map50_95"):
        table.add_row(key, "", "-" if result[key] is None else f"{result[key]:.3f}")
    table.add_row(
        "ms per picture", "", f"{result['ms_per_image_p50']} ({result['provider']}, {result['size_px']} px)"
    )
    (console or Console(highlight=False)).print(table)
