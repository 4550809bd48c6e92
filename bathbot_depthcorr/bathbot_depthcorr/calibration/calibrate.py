"""From a recorded bag, or a folder of views, to a correction on file and a report to believe it by."""

from collections.abc import Callable
from pathlib import Path

from bathbot_depthcorr.calibration.fit import (
    DEFAULT_MODEL,
    calibrate,
    checked_views,
    find_fit,
    fit_and_judge,
    with_learning,
)
from bathbot_depthcorr.calibration.report import CalibrationReport
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.files import CalibrationFileError
from bathbot_depthcorr.views.bag_views import Recording, read_boards
from bathbot_depthcorr.views.chessboard import Chessboard
from bathbot_depthcorr.views.colour_reference import ViewSet, views_from_boards
from bathbot_depthcorr.views.view_folder import is_view_folder, read_view_folder
from bathbot_depthcorr.views.views import Steps

__all__ = [
    "DEFAULT_MODEL",
    "calibrate",
    "calibrate_bag",
    "check_target",
    "make_calibration",
    "read_views",
    "views_of_recording",
]


def read_views(source: Path, board: Chessboard, steps: Steps) -> ViewSet:
    """Read a rosbag2 recording, or a plain folder of .npz views.

    Raises:
        DepthcorrError: In one line, if it is neither, or damaged.
    """
    if is_view_folder(source):
        return read_view_folder(source, steps)
    return views_of_recording(read_boards(source, board, steps), board)


def views_of_recording(recording: Recording, board: Chessboard) -> ViewSet:
    """Turn still poses before a board into walls whose plane is known."""
    views, reference = views_from_boards(recording.boards, board, recording.colour_camera)
    return ViewSet(views, recording.unit, reference, tuple(recording.notes))


def make_calibration(
    read: Callable[[Steps], ViewSet], out: Path, model: str, steps: Steps
) -> CalibrationReport:
    """Read views, fit, judge, and write the correction with its picture beside it (`out` as .png).

    Args:
        read: Gives the views; what it raises ends the job.
        out: Where to write the .npz file; nothing is written unless all went well.
        model: One of `MODELS`.
        steps: Hears how it goes.

    Raises:
        DepthcorrError: In one line, on places or views that do not serve.
    """
    check_target(model, out)
    with steps.stage("read", "read the views"):
        found = read(steps)
    with steps.stage("fit", f"fit {model} to {len(found.views)} views"):
        checked = checked_views(found)
        correction, report = fit_and_judge(checked, model, steps)
    with steps.stage("learn", "fit to fewer views, for the learning curve"):
        report = with_learning(report, checked, steps)
    with steps.stage("write", f"write {out} and its picture"):
        from bathbot_depthcorr.calibration.plots import save_plots  # matplotlib only where it is wanted

        correction.save(out)
        save_plots(report, out.with_suffix(".png"))
    return report


def calibrate_bag(
    bag: Path,
    out: Path,
    model: str = DEFAULT_MODEL,
    board: tuple[int, int] = (11, 8),
    square: float = 0.05,
    progress: Callable[[str], None] = lambda _: None,
) -> CalibrationReport:
    """Make a correction from a recorded bag, or a folder of views, and write it.

    Args:
        bag: A rosbag2 bag with the raw topics of the camera, or a folder of .npz views.
        out: Where to write the .npz file; nothing is written unless all went well.
        model: One of `MODELS`.
        board: Inner corners along and across.
        square: Edge of a square [m].
        progress: Called with one line per step.

    Raises:
        DepthcorrError: In one line, on a bag, board or views that do not serve.
    """
    chessboard = Chessboard(*board, square)
    return make_calibration(
        lambda steps: read_views(Path(bag), chessboard, steps), Path(out), model, Steps(progress)
    )


def check_target(model: str, out: Path) -> None:
    """Refuse an unknown model and places that cannot be written, before the work begins.

    Raises:
        DepthcorrError: With what to try.
    """
    find_fit(model)
    if not out.parent.is_dir():
        raise CalibrationFileError(
            f"folder {out.parent} does not exist; create it or choose another for {out.name}"
        )
    if out.suffix != ".npz":
        raise SettingsError(f"the calibration file must end in .npz, got {out.name}")
