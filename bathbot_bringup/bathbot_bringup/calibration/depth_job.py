"""`bathbot calibrate depth`: from a bag, a folder or the running camera to files and a table."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bathbot_depthcorr.calibration.calibrate import (
    check_target,
    make_calibration,
    read_views,
    views_of_recording,
)
from bathbot_depthcorr.calibration.report import CalibrationReport
from bathbot_depthcorr.views.chessboard import Chessboard
from bathbot_depthcorr.views.colour_reference import ViewSet
from bathbot_depthcorr.views.view_folder import is_view_folder, write_view_folder
from bathbot_depthcorr.views.views import Steps
from rich.console import Console
from rich.table import Table

from bathbot_bringup.bag.reading import check_whole
from bathbot_bringup.errors import InputError
from bathbot_bringup.files import write_json
from bathbot_bringup.graph.stages import StageLog


@dataclass(frozen=True, slots=True)
class Job:
    """What to calibrate from, and what to write.

    Attributes:
        source: Bag or folder of views; None when live.
        live: Whether to watch the running camera.
        camera: Namespace of its topics.
        board: The chessboard on the wall.
        model: Name of the depth model.
        out: Calibration file.
        json: File for the numbers of the report, or None.
        views: Folder for the views, or None.
    """

    source: Path | None
    live: bool
    camera: str
    board: Chessboard
    model: str
    out: Path
    json: Path | None
    views: Path | None

    def __post_init__(self) -> None:
        """Refuse jobs without a source, with two, or whose places are taken."""
        if self.live == (self.source is not None):
            raise InputError("give either a bag, or --live to watch the running camera")
        if self.views is not None and self.views.exists():
            raise InputError(f"{self.views} exists already; choose another folder for --views")
        for path in (self.json, self.views):
            if path is not None and not path.absolute().parent.is_dir():
                raise InputError(f"folder {path.parent} does not exist; create it or choose another")


def run_job(job: Job) -> None:
    """Calibrate, write the files, print the report.

    Raises:
        BathbotError: In one line; then nothing is written.
    """
    check_target(job.model, job.out)
    if job.source is not None and not is_view_folder(job.source):
        check_whole(job.source)
    found = []
    read = _reader(job)

    def remember(steps: Steps) -> ViewSet:
        found.append(read(steps))
        return found[0]

    report = make_calibration(remember, job.out, job.model, StageLog())
    if job.views is not None:
        write_view_folder(job.views, found[0])
    if job.json is not None:
        write_json(job.json, report.numbers())
    print_calibration(report)


def _reader(job: Job) -> Callable[[Steps], ViewSet]:
    """What gives the views of a job; a running camera is watched before it returns."""
    if job.source is not None:
        return lambda steps: read_views(job.source, job.board, steps)
    from bathbot_bringup.calibration.coach_node import coach  # ROS only where it is wanted

    recording = coach(job.board, job.camera)
    return lambda steps: views_of_recording(recording, job.board)


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
