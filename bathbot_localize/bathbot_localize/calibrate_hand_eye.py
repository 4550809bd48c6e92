"""`bathbot calibrate hand-eye`: from a recorded bag to a hand-eye file."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from bathbot_localize.hand_eye import HandEyeReport, solve_hand_eye
from bathbot_localize.hand_eye_bag import read_views
from bathbot_localize.hand_eye_file import save_hand_eye
from bathbot_localize.marker import MARKER_ID, MARKER_SIZE


def calibrate_bag(
    bag: Path, out: Path, marker_id: int = MARKER_ID, marker_size: float = MARKER_SIZE,
    progress: Callable[[str], None] | None = None,
) -> HandEyeReport:  # fmt: skip
    """Calibrate from a bag and write the result; without a sound result nothing is written.

    Args:
        bag: Colour pictures, camera_info and the arm's /tf or /tool_pose, with the arm at rest now and then.
        out: YAML file to write; its date is that of the recording.
        marker_id: Number of the marker in OpenCV's DICT_ARUCO_ORIGINAL.
        marker_size: Edge of its black square [m].
        progress: Called with a line for each arm pose.

    Raises:
        BathbotError: When the bag cannot be used; the message says what to record.
    """
    recording = read_views(Path(bag), marker_id, progress or (lambda line: None))
    date = datetime.fromtimestamp(recording.begun, UTC).strftime("%Y-%m-%d")
    report = solve_hand_eye(recording.views, recording.camera, marker_size, date)
    save_hand_eye(report.hand_eye, out)
    return report
