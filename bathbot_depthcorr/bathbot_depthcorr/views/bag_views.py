"""Finds still poses before the chessboard in a rosbag2 recording; needs no ROS.

Two passes: the colour images give the spans in which nothing moves and the board in their mean; the depth
images of these spans are then averaged in inverse depth, in which stereo noise is symmetric.
"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros.bag_messages import BagError, message_counts, messages
from bathbot_depthcorr.ros.image_decoding import colour_from_image, depth_from_image, stamp_seconds
from bathbot_depthcorr.views.bag_camera import COLOUR, DEPTH, find_topics, read_camera, refuse_other_size
from bathbot_depthcorr.views.chessboard import BoardNotFoundError, Chessboard, find_corners
from bathbot_depthcorr.views.colour_reference import BoardView
from bathbot_depthcorr.views.sharpness import MOST_EDGE_WIDTH, edge_width
from bathbot_depthcorr.views.still_watch import MOST_FRAMES, MeanDepth, StillSpan, StillWatch, mean_depth
from bathbot_depthcorr.views.views import Steps

__all__ = ["BagError", "Recording", "messages", "read_boards"]


class Recording(NamedTuple):
    """What a calibration is made from: still poses and the cameras, all as the camera reports them.

    Attributes:
        boards: One for each still pose.
        colour_camera: As in camera_info.
        unit: The same of the depth stream.
        notes: What was left out or contradicts itself, one line each.
    """

    boards: list[BoardView]
    colour_camera: Pinhole
    unit: CameraUnit
    notes: list[str]


def read_boards(bag: Path, board: Chessboard, steps: Steps = Steps()) -> Recording:
    """Read the still poses of a bag.

    Args:
        bag: Folder of a rosbag2 recording, or its .mcap file.
        board: The chessboard on the wall.
        steps: Hears how it goes.

    Raises:
        BagError: If the bag is unreadable, lacks a topic, holds aligned depth or no still, sharp board.
    """
    topics = find_topics(bag)
    colour_camera, unit, notes = read_camera(bag, topics)
    spans, corners, left_out = [], [], Counter()
    for span in _still_spans(bag, topics[COLOUR], colour_camera, steps):
        try:
            found = find_corners(span.grey, board)
        except BoardNotFoundError:
            left_out["without the board"] += 1
            continue
        if (width := edge_width(span.grey, found, board)) > MOST_EDGE_WIDTH:
            left_out["blurred"] += 1
            steps.note(
                f"pose left out: edges of the board are {width:.1f} px wide, sharp are {MOST_EDGE_WIDTH:.0f}"
            )
            continue
        corners.append(found)
        spans.append(span)
        steps.note(f"pose {len(spans)} at {span.start - spans[0].start:.1f} s: board found")
    if not spans:
        raise _no_board(bag, board, left_out)
    boards = []
    for seen, depth in zip(corners, _average_depth(bag, topics[DEPTH], spans, unit, steps), strict=True):
        if depth is None:
            left_out["without depth"] += 1
        else:
            boards.append(BoardView(seen, *depth))
    left = [f"{count} still poses {why} were left out" for why, count in left_out.items()]
    steps.note("; ".join([f"{len(boards)} poses with board and depth", *left]))
    return Recording(boards, colour_camera, unit, [*notes, *left])


def _no_board(bag: Path, board: Chessboard, left_out: Counter[str]) -> BagError:
    name = f"{board.columns}x{board.rows}"
    if left_out["blurred"]:
        return BagError(
            f"{bag} shows the {name} board blurred in all {left_out['blurred']} poses that have it: edges "
            f"wider than {MOST_EDGE_WIDTH} px; add light, and wait until the camera is still"
        )
    return BagError(
        f"{bag} shows no {name} board in {left_out['without the board']} still poses; hold the camera "
        "still for a second per pose, with all of the board in view, and check --board"
    )


def _still_spans(bag: Path, topic: str, camera: Pinhole, steps: Steps) -> Iterator[StillSpan]:
    """Spans in which the colour image does not change."""
    watch, total = StillWatch(), message_counts(bag)[topic]
    for number, (_, image) in enumerate(messages(bag, topic), start=1):
        colour = colour_from_image(image)
        refuse_other_size("colour", colour.shape, camera)
        if (span := watch.push(stamp_seconds(image.header.stamp), colour)) is not None:
            yield span
        steps.progress(number / total, f"picture {number} of {total}")
    if (span := watch.span()) is not None:
        yield span


def _average_depth(
    bag: Path, topic: str, spans: list[StillSpan], unit: CameraUnit, steps: Steps
) -> list[MeanDepth | None]:
    """Mean depth of each span; None without depth."""
    means: list[MeanDepth | None] = [None] * len(spans)
    current, stack = 0, []
    for _, image in messages(bag, topic):
        stamp = stamp_seconds(image.header.stamp)
        while current < len(spans) and stamp > spans[current].end:
            means[current] = mean_depth(stack) if stack else None
            current, stack = current + 1, []
            steps.progress(current / len(spans), f"depth of pose {current} of {len(spans)}")
        if current == len(spans):
            break
        if stamp >= spans[current].start and len(stack) < MOST_FRAMES:
            stack.append(depth_from_image(image))
            refuse_other_size("depth", stack[-1].shape, unit.depth_camera)
    if stack:
        means[current] = mean_depth(stack)
    return means
