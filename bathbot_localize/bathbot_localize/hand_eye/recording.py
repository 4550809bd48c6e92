"""Read the views of a hand-eye calibration from a bag, still arm poses that show the marker, and solve."""

from bisect import bisect_left
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.frame_tree import FrameTree, UnknownFrameError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, rotation_angle
from bathbot_depthcorr.ros.image_decoding import colour_from_image, pinhole_from_info, stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transform_from_message, transform_from_pose
from bathbot_depthcorr.views.bag_views import messages
from numpy.typing import NDArray

from bathbot_localize.arm.arm_shape import installed_shape
from bathbot_localize.errors import LocalizeError
from bathbot_localize.hand_eye.calibration_file import save_hand_eye
from bathbot_localize.hand_eye.marker import MARKER_ID, MARKER_SIZE, MarkerNotFoundError, find_marker
from bathbot_localize.hand_eye.solver import HandEyeReport, MarkerView, solve_hand_eye

Array = NDArray[np.float64]
COLOUR, COLOUR_INFO = "/camera/camera/color/image_raw", "/camera/camera/color/camera_info"
TOOL_POSE, TF = "/tool_pose", "/tf"
BASE = "base_link"
LEAST_STILL = 0.5  # [s] an arm pose must last
_SETTLE = 0.15  # [s] left out at both ends: clocks of arm and camera differ a little
_SAME_PLACE, _SAME_TURN = 0.0005, 0.002  # [m], [rad] within which the arm stands still
_PICTURES = 6  # of one pose in which the marker is looked for
_STEADY_PX = 1.0  # corners of one pose must agree within this


class HandEyeBagError(LocalizeError):
    """A bag that does not hold what a hand-eye calibration needs."""


class HandEyeRecording(NamedTuple):
    """Views of the marker, the colour camera, and the time [s] of the first picture."""

    views: list[MarkerView]
    camera: Pinhole
    begun: float


class StillPose(NamedTuple):
    """The arm at rest from `begin` to `end` [s] with the tool at T_base_tool, shape (4, 4)."""

    begin: float
    end: float
    T_base_tool: Array


def read_views(
    bag: Path, marker_id: int = MARKER_ID, tell: Callable[[str], None] = lambda line: None
) -> HandEyeRecording:
    """Read the views of a bag.

    The tool's pose is taken from /tf (the flange) or, when that is missing, from /tool_pose; which of
    the two does not matter, since the marker's place on the tool is solved for as well.

    Raises:
        BathbotError: When the bag cannot be read or lacks pictures, camera_info or arm poses.
    """
    poses = still_poses(*tool_track(bag, installed_shape().flange))
    if not poses:
        raise HandEyeBagError(
            f"{bag} holds no arm pose of {LEAST_STILL} s at rest; is {TF} or {TOOL_POSE} in it, "
            "and did the arm pause?"
        )
    infos = [message for _, message in messages(bag, COLOUR_INFO)][:1]
    if not infos:
        raise HandEyeBagError(f"{bag} has no {COLOUR_INFO}; record with --profile full")
    camera = pinhole_from_info(infos[0])
    seen: list[list[Array]] = [[] for _ in poses]
    tried = [0] * len(poses)
    begun = float("nan")
    for stamp, image in _pictures(bag):
        begun = stamp if np.isnan(begun) else begun
        index = bisect_left([pose.end for pose in poses], stamp)
        if index < len(poses) and poses[index].begin <= stamp and tried[index] < _PICTURES:
            tried[index] += 1
            _look(image, camera, marker_id, seen[index])
    if np.isnan(begun):
        raise HandEyeBagError(f"{bag} has no {COLOUR}; record with --profile full")
    views = []
    for number, (pose, corners) in enumerate(zip(poses, seen, strict=True), start=1):
        steady = len(corners) > 0 and np.ptp(np.stack(corners), axis=0).max() <= _STEADY_PX
        tell(f"arm pose {number} of {len(poses)}: {_verdict(len(corners), tried[number - 1], steady)}")
        if steady:
            views.append(MarkerView(pose.T_base_tool, np.mean(corners, axis=0)))
    return HandEyeRecording(views, camera, begun)


def tool_track(bag: Path, flange: str) -> tuple[Array, Array]:
    """Times [s], shape (n,), and T_base_tool, shape (n, 4, 4), over a bag."""
    tree, stamps, transforms, tool_poses = FrameTree(memory=1), [], [], []
    for topic, message in messages(bag, TF, TOOL_POSE):
        if topic == TOOL_POSE:
            tool_poses.append(
                (
                    stamp_seconds(message.header.stamp),
                    transform_from_pose(message.pose),
                )
            )
            continue
        for entry in message.transforms:
            stamp = stamp_seconds(entry.header.stamp)
            transform = transform_from_message(entry.transform)
            tree.add(entry.header.frame_id, entry.child_frame_id, transform, stamp)
            if entry.child_frame_id == flange:
                try:
                    transforms.append(tree.lookup(BASE, flange))
                    stamps.append(stamp)
                except UnknownFrameError:
                    continue  # the first messages may hold a part of the chain only
    if not transforms:
        stamps, transforms = [stamp for stamp, _ in tool_poses], [pose for _, pose in tool_poses]
    return np.array(stamps), np.array(transforms).reshape(-1, 4, 4)


def still_poses(stamps: Array, T_base_tool: Array) -> list[StillPose]:
    """Spans of time in which the tool does not move, shortened at both ends for settling."""
    poses, first = [], 0
    for index in range(1, len(stamps) + 1):
        if index < len(stamps) and _same(T_base_tool[first], T_base_tool[index]):
            continue
        if stamps[index - 1] - stamps[first] >= LEAST_STILL:
            middle = T_base_tool[(first + index - 1) // 2]
            poses.append(StillPose(stamps[first] + _SETTLE, stamps[index - 1] - _SETTLE, middle))
        first = index
    return poses


def _pictures(bag: Path):
    for _, image in messages(bag, COLOUR):
        yield stamp_seconds(image.header.stamp), image


def _look(image: Any, camera: Pinhole, marker_id: int, corners: list[Array]) -> None:
    """Add the marker's corners in one picture, if it shows the marker."""
    try:
        grey = cv2.cvtColor(colour_from_image(image), cv2.COLOR_RGB2GRAY)
        corners.append(find_marker(grey, camera, marker_id))
    except MarkerNotFoundError:
        return


def _verdict(found: int, tried: int, steady: bool) -> str:
    if found == 0:
        return f"no marker in {tried} pictures" if tried else "no picture"
    return f"marker in {found} of {tried} pictures" if steady else "the marker moves, left out"


def _same(first: Array, second: Array) -> bool:
    change = inverse(first) @ second
    return bool(np.linalg.norm(change[:3, 3]) <= _SAME_PLACE and rotation_angle(change[:3, :3]) <= _SAME_TURN)


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
