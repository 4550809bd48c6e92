"""The one camera of a recording: its topics, its intrinsics and who it is; refuses what is not raw."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.frame_tree import FrameTree, UnknownFrameError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, rotation_angle
from bathbot_depthcorr.ros.bag_messages import BagError, message_counts, messages
from bathbot_depthcorr.ros.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.ros.image_decoding import pinhole_from_info, transform_from_extrinsics
from bathbot_depthcorr.ros.pose_decoding import transform_from_message

Array = NDArray[np.float64]

COLOUR, COLOUR_INFO = "color/image_raw", "color/camera_info"
DEPTH, DEPTH_INFO = "depth/image_rect_raw", "depth/camera_info"
EXTRINSICS, STATIC_FRAMES = "extrinsics/depth_to_color", "/tf_static"
DIAGNOSTICS = "/diagnostics"
NEEDED = (COLOUR, COLOUR_INFO, DEPTH, DEPTH_INFO, EXTRINSICS)
MOST_TRANSLATION = 0.5  # [m] between the depth and colour imagers of one housing
SAME_SHIFT, SAME_TURN = 1e-4, np.deg2rad(0.01)  # [m], [rad] within which two extrinsics agree


def find_topics(bag: Path) -> dict[str, str]:
    """Full names of the camera's topics, whatever its namespace; static frames may stand for the extrinsics.

    Raises:
        BagError: If one is lacking, or there are several cameras.
    """
    counts, found = message_counts(bag), {}
    for name in NEEDED:
        matches = [topic for topic, count in counts.items() if topic.endswith(f"/{name}") and count]
        if name == EXTRINSICS and not matches and counts.get(STATIC_FRAMES):
            continue
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
    cameras = {topic.removesuffix(f"/{name}") for name, topic in found.items()}
    if len(cameras) > 1:
        raise BagError(
            f"colour and depth of {bag} are of {len(cameras)} cameras, {_few(cameras)}; record one camera"
        )
    return found


class RecordedCamera(NamedTuple):
    """The colour camera, the unit, and what is odd about them, one line each."""

    colour: Pinhole
    unit: CameraUnit
    notes: list[str]


def read_camera(bag: Path, topics: dict[str, str]) -> RecordedCamera:
    """The colour camera and the unit, from the first message of each kind and all static frames.

    Args:
        bag: The recording.
        topics: What `find_topics` gave.

    Raises:
        BagError: If the depth is aligned, nothing tells the depth -> colour transform, or the diagnostics
            are of several cameras.
    """
    seen: dict[str, Any] = {}
    health, serials, frames = CameraHealth(), set(), FrameTree()
    names = {topics[name]: name for name in (COLOUR_INFO, DEPTH_INFO, EXTRINSICS) if name in topics}
    for topic, message in messages(bag, *names, DIAGNOSTICS, STATIC_FRAMES):
        if topic == DIAGNOSTICS:
            health = camera_health(message, health)
            serials |= {health.serial} - {""}
        elif topic == STATIC_FRAMES:
            for entry in message.transforms:
                transform = transform_from_message(entry.transform)
                frames.add(entry.header.frame_id, entry.child_frame_id, transform)
        else:
            seen.setdefault(names[topic], message)
    if len(serials) > 1:
        raise BagError(
            f"{bag} holds diagnostics of {len(serials)} cameras, {_few(serials)}; record one camera only"
        )
    transform, notes = _extrinsics(bag, seen, frames)
    return RecordedCamera(*camera_from_messages(str(bag), seen, transform, health), notes)


def _extrinsics(bag: Path, seen: dict[str, Any], frames: FrameTree) -> tuple[Array, list[str]]:
    """Depth -> colour by its own topic, else by the static frames; a note where the two differ."""
    depth, colour = (seen[name].header.frame_id for name in (DEPTH_INFO, COLOUR_INFO))
    told = transform_from_extrinsics(seen[EXTRINSICS]) if EXTRINSICS in seen else None
    try:
        joined = frames.lookup(colour, depth)
    except UnknownFrameError as error:
        if told is not None:
            return told, []
        raise BagError(
            f"{bag} has no messages on .../{EXTRINSICS}, and its {STATIC_FRAMES} does not join {depth} to "
            f"{colour}; record the camera's raw topics"
        ) from error
    if told is None:
        return joined, []
    apart = inverse(joined) @ told
    shift, turn = float(np.linalg.norm(apart[:3, 3])), float(rotation_angle(apart[:3, :3]))
    if shift <= SAME_SHIFT and turn <= SAME_TURN:
        return told, []
    return told, [
        f"{EXTRINSICS} and {STATIC_FRAMES} differ by {1e3 * shift:.2f} mm and {np.rad2deg(turn):.3f} deg; "
        f"{EXTRINSICS} is used"
    ]


def camera_from_messages(
    source: str, seen: dict[str, Any], transform: Array, health: CameraHealth
) -> tuple[Pinhole, CameraUnit]:
    """The colour camera and the unit from camera_info of both streams and the extrinsics.

    Args:
        source: What is read, for the error.
        seen: Messages under `COLOUR_INFO` and `DEPTH_INFO`.
        transform: Depth -> colour by the factory, shape (4, 4).
        health: Serial number and temperature.

    Raises:
        BagError: If depth and colour are in one frame, or as far apart as no camera has them.
    """
    frame = seen[DEPTH_INFO].header.frame_id
    if frame == seen[COLOUR_INFO].header.frame_id:
        raise BagError(
            f"depth and colour of {source} are both in frame {frame!r}: the depth is aligned to "
            "colour; record depth/image_rect_raw"
        )
    apart = float(np.linalg.norm(transform[:3, 3]))
    if not apart <= MOST_TRANSLATION:
        raise BagError(
            f"the extrinsics of {source} put depth and colour {apart:.3g} m apart, at most "
            f"{MOST_TRANSLATION} m fit one camera; restart the camera driver and record again"
        )
    unit = CameraUnit(pinhole_from_info(seen[DEPTH_INFO]), transform, health.serial, health.temperature)
    return pinhole_from_info(seen[COLOUR_INFO]), unit


def refuse_other_size(kind: str, shape: tuple[int, ...], camera: Pinhole) -> None:
    """Compare a picture, shape (H, W, ...), with its camera_info.

    Raises:
        BagError: If the sizes differ.
    """
    if shape[:2] != (camera.height, camera.width):
        raise BagError(
            f"a {kind} picture has {shape[1]}x{shape[0]} px, its camera_info says "
            f"{camera.width}x{camera.height}; do not change the profile while recording"
        )


def _few(topics: Iterable[str]) -> str:
    names = sorted(topics)
    return ", ".join(names[:6]) + (", ..." if len(names) > 6 else "") or "no topics"
