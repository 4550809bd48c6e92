"""The one camera of a recording: its topics, its intrinsics and who it is; refuses what is not raw."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros.bag_messages import BagError, message_counts, messages
from bathbot_depthcorr.ros.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.ros.image_decoding import pinhole_from_info, transform_from_extrinsics

COLOUR, COLOUR_INFO = "color/image_raw", "color/camera_info"
DEPTH, DEPTH_INFO = "depth/image_rect_raw", "depth/camera_info"
EXTRINSICS, DIAGNOSTICS = "extrinsics/depth_to_color", "/diagnostics"
NEEDED = (COLOUR, COLOUR_INFO, DEPTH, DEPTH_INFO, EXTRINSICS)
MOST_TRANSLATION = 0.5  # [m] between the depth and colour imagers of one housing


def find_topics(bag: Path) -> dict[str, str]:
    """Full names of the camera's topics, whatever its namespace.

    Raises:
        BagError: If one is lacking, or there are several cameras.
    """
    counts, found = message_counts(bag), {}
    for name in NEEDED:
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
    cameras = {topic.removesuffix(f"/{name}") for name, topic in found.items()}
    if len(cameras) > 1:
        raise BagError(
            f"colour and depth of {bag} are of {len(cameras)} cameras, {_few(cameras)}; record one camera"
        )
    return found


def read_camera(bag: Path, topics: dict[str, str]) -> tuple[Pinhole, CameraUnit]:
    """The colour camera and the unit, from the first message of each kind.

    Raises:
        BagError: If the depth is aligned, or the diagnostics are of several cameras.
    """
    seen: dict[str, Any] = {}
    health, serials = CameraHealth(), set()
    names = {topics[name]: name for name in (COLOUR_INFO, DEPTH_INFO, EXTRINSICS)}
    for topic, message in messages(bag, *names, DIAGNOSTICS):
        if topic == DIAGNOSTICS:
            health = camera_health(message, health)
            serials |= {health.serial} - {""}
        else:
            seen.setdefault(names[topic], message)
    if len(serials) > 1:
        raise BagError(
            f"{bag} holds diagnostics of {len(serials)} cameras, {_few(serials)}; record one camera only"
        )
    return camera_from_messages(str(bag), seen, health)


def camera_from_messages(
    source: str, seen: dict[str, Any], health: CameraHealth
) -> tuple[Pinhole, CameraUnit]:
    """The colour camera and the unit from camera_info of both streams and the extrinsics.

    Args:
        source: What is read, for the error.
        seen: Messages under `COLOUR_INFO`, `DEPTH_INFO` and `EXTRINSICS`.
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
    transform = transform_from_extrinsics(seen[EXTRINSICS])
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
