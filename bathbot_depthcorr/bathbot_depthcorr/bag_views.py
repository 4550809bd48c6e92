"""Finds still poses before the chessboard in a rosbag2 recording; needs no ROS.

Two passes: the colour images give the spans in which nothing moves and the board in their mean; the depth
images of these spans are then averaged in inverse depth, in which stereo noise is symmetric.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from bathbot_depthcorr.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.chessboard import BoardNotFoundError, Chessboard, find_corners
from bathbot_depthcorr.colour_reference import BoardView
from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.errors import BathbotError, DepthcorrError
from bathbot_depthcorr.image_decoding import (
    colour_from_image,
    depth_from_image,
    pinhole_from_info,
    stamp_seconds,
    transform_from_extrinsics,
)
from bathbot_depthcorr.pinhole import Pinhole

COLOUR, COLOUR_INFO = "color/image_raw", "color/camera_info"
DEPTH, DEPTH_INFO = "depth/image_rect_raw", "depth/camera_info"
EXTRINSICS, DIAGNOSTICS = "extrinsics/depth_to_color", "/diagnostics"
LEAST_FRAMES = 2  # of colour in one still span
MOST_FRAMES = 10  # of depth: more bury nothing, as the noise of the texture is frozen
STILL = 8.0  # grey levels: the 99th percentile of what may change while nothing moves
_REDUCTION = 4


class BagError(DepthcorrError):
    """A recording that is unreadable or lacks what a calibration needs."""


class Recording(NamedTuple):
    """What a bag holds for a calibration: still poses and the cameras, all as the camera reports them."""

    boards: list[BoardView]
    colour_camera: Pinhole
    unit: CameraUnit


class StillSpan(NamedTuple):
    """A span of time [s] without motion, and the mean brightness of its frames, uint8, shape (H, W)."""

    start: float
    end: float
    grey: NDArray[np.uint8]


def read_boards(bag: Path, board: Chessboard, tell: Callable[[str], None] = lambda _: None) -> Recording:
    """Read the still poses of a bag.

    Args:
        bag: Folder of a rosbag2 recording, or its .mcap file.
        board: The chessboard on the wall.
        tell: Called with one line per step.

    Raises:
        BagError: If the bag is unreadable, lacks a topic, holds aligned depth or no still board.
    """
    topics = _find_topics(bag)
    colour_camera, unit = _read_cameras(bag, topics)
    spans, corners, missed = [], [], 0
    for span in still_spans(bag, topics[COLOUR]):
        try:
            corners.append(find_corners(span.grey, board))
            spans.append(span)
            tell(f"pose {len(spans)} at {span.start - spans[0].start:.1f} s: board found")
        except BoardNotFoundError:
            missed += 1
    if not spans:
        raise BagError(
            f"{bag} shows no {board.columns}x{board.rows} board in {missed} still poses; hold the camera "
            "still for a second per pose, with all of the board in view, and check --board"
        )
    depths = _average_depth(bag, topics[DEPTH], spans)
    boards = [
        BoardView(seen, *depth) for seen, depth in zip(corners, depths, strict=True) if depth is not None
    ]
    tell(f"{len(boards)} poses with board and depth, {missed} still poses without the board")
    return Recording(boards, colour_camera, unit)


def messages(bag: Path, *topics: str) -> Iterator[tuple[str, Any]]:
    """Topic and message, in order of time, of a recording.

    Raises:
        BagError: If the bag is missing, cut off or damaged.
    """
    try:
        with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            wanted = [connection for connection in reader.connections if connection.topic in topics]
            for connection, _, raw in reader.messages(wanted) if wanted else ():
                yield connection.topic, reader.deserialize(raw, connection.msgtype)
    except BathbotError:
        raise
    except Exception as error:  # a damaged file leads the parser to errors of any kind
        raise _unreadable(bag, error) from error


def still_spans(bag: Path, topic: str) -> Iterator[StillSpan]:
    """Spans in which the colour image does not change."""
    first, total, stamps = None, None, []
    for _, image in messages(bag, topic):
        grey = cv2.cvtColor(colour_from_image(image), cv2.COLOR_RGB2GRAY)
        small = cv2.resize(grey, None, fx=1 / _REDUCTION, fy=1 / _REDUCTION, interpolation=cv2.INTER_AREA)
        if (
            first is not None
            and first.shape == small.shape
            and np.percentile(cv2.absdiff(small, first), 99) <= STILL
        ):
            total += grey
            stamps.append(stamp_seconds(image.header.stamp))
            continue
        if len(stamps) >= LEAST_FRAMES:
            yield StillSpan(stamps[0], stamps[-1], np.rint(total / len(stamps)).astype(np.uint8))
        first, total, stamps = small, grey.astype(np.float64), [stamp_seconds(image.header.stamp)]
    if len(stamps) >= LEAST_FRAMES:
        yield StillSpan(stamps[0], stamps[-1], np.rint(total / len(stamps)).astype(np.uint8))


def _find_topics(bag: Path) -> dict[str, str]:
    """Full names of the camera's topics, whatever its namespace."""
    try:
        with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            counts = {connection.topic: connection.msgcount for connection in reader.connections}
    except Exception as error:  # as above
        raise _unreadable(bag, error) from error
    found = {}
    for name in (COLOUR, COLOUR_INFO, DEPTH, DEPTH_INFO, EXTRINSICS):
        matches = [topic for topic, count in counts.items() if topic.endswith(f"/{name}") and count]
        if not matches:
            aligned = any("aligned_depth" in topic for topic in counts) and name in (DEPTH, DEPTH_INFO)
            hint = (
                "it holds aligned depth, but the map belongs to raw depth"
                if aligned
                else f"it has {_few(counts)}"
            )
            raise BagError(f"{bag} has no messages on .../{name}; {hint}; record the camera's raw topics")
        if len(matches) > 1:
            raise BagError(
                f"{bag} has {len(matches)} topics .../{name}: {_few(matches)}; record one camera only"
            )
        found[name] = matches[0]
    return found


def _few(topics: Any) -> str:
    names = sorted(topics)
    return ", ".join(names[:6]) + (", ..." if len(names) > 6 else "") or "no topics"


def _read_cameras(bag: Path, topics: dict[str, str]) -> tuple[Pinhole, CameraUnit]:
    """The colour camera and the unit, from the first message of each kind."""
    seen: dict[str, Any] = {}
    health = CameraHealth()
    frames = {}
    names = {topics[name]: name for name in (COLOUR_INFO, DEPTH_INFO, EXTRINSICS)} | {
        DIAGNOSTICS: DIAGNOSTICS
    }
    for topic, message in messages(bag, *names):
        if topic == DIAGNOSTICS:
            health = camera_health(message, health)
            continue
        seen.setdefault(names[topic], message)
        if hasattr(message, "header"):
            frames.setdefault(names[topic], message.header.frame_id)
    if frames.get(DEPTH_INFO) == frames.get(COLOUR_INFO):
        raise BagError(
            f"depth and colour of {bag} are both in frame {frames[DEPTH_INFO]!r}: the depth is aligned to "
            "colour; record depth/image_rect_raw"
        )
    transform = transform_from_extrinsics(seen[EXTRINSICS])
    unit = CameraUnit(pinhole_from_info(seen[DEPTH_INFO]), transform, health.serial, health.temperature)
    return pinhole_from_info(seen[COLOUR_INFO]), unit


def _average_depth(
    bag: Path, topic: str, spans: list[StillSpan]
) -> list[tuple[NDArray[np.float32], int, float] | None]:
    """Per span: mean depth [m], number of frames and noise of inverse depth [1/m]; None without depth."""
    means: list[tuple[NDArray[np.float32], int, float] | None] = [None] * len(spans)
    current, stack = 0, []
    for _, image in messages(bag, topic):
        stamp = stamp_seconds(image.header.stamp)
        while current < len(spans) and stamp > spans[current].end:
            means[current] = _mean_depth(stack) if stack else None
            current, stack = current + 1, []
        if current == len(spans):
            break
        if stamp >= spans[current].start and len(stack) < MOST_FRAMES:
            stack.append(depth_from_image(image))
    if stack:
        means[current] = _mean_depth(stack)
    return means


def _mean_depth(stack: list[NDArray[np.float32]]) -> tuple[NDArray[np.float32], int, float]:
    inverse = 1.0 / np.stack(stack)
    count = np.isfinite(inverse).sum(axis=0)
    known = count >= max(1, (len(stack) + 1) // 2)
    mean = np.nansum(inverse, axis=0) / np.maximum(count, 1)
    depth = np.where(known, 1.0 / np.where(known, mean, 1.0), np.nan).astype(np.float32)
    full = count == len(stack)
    noise = float(np.median(inverse[:, full].std(axis=0, ddof=1))) if len(stack) > 1 and full.any() else 0.0
    return depth, len(stack), noise


def _unreadable(bag: Path, error: Exception) -> BagError:
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return BagError(
        f"cannot read bag {bag}: {reason}; is it complete (ros2 bag reindex repairs a cut-off one)?"
    )
