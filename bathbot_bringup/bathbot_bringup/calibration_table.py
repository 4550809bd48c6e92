"""Results of a depth calibration on the terminal."""

from bathbot_depthcorr.calibration_report import CalibrationReport
from rich.console import Console
from rich.table import Table


def print_calibration(report: CalibrationReport, console: Console | None = None) -> None:
    """Print the errors on held-out views, then what decides absolute accuracy, and the warnings."""
    console = console or Console(highlight=False)
    table = Table(
        title=f"{report.model}, {report.views} views: errors on {len(report.held_out)} held out [mm]",
        title_justify="left",
    )
    for heading in (
        "distance",
        "mean |error| before",
        "after",
        "signed before",
        "after",
        "RMSE before",
        "after",
    ):
        table.add_column(heading, justify="right")
    for view in report.held_out:
        table.add_row(
            f"{view.distance:.2f} m", _mm(view.absolute_before), _mm(view.absolute_after),
            f"{view.signed_before * 1e3:+.2f}", f"{view.signed_after * 1e3:+.2f}",
            _mm(view.rmse_before), _mm(view.rmse_after),
        )  # fmt: skip
    table.add_section()
    table.add_row("mean", _mm(report.before), _mm(report.after))
    console.print(table)
    for line in report.references():
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.2f}"
