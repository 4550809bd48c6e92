"""The result of hand-eye calibration as a YAML file: where the camera is in the base frame."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from bathbot_depthcorr.bounded_files import read_yaml
from bathbot_depthcorr.files import write_atomically
from bathbot_depthcorr.geometry.rigid import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    transform_from,
)
from numpy.typing import ArrayLike, NDArray

from bathbot_localize.errors import LocalizeError

KIND = "bathbot hand-eye"
PARENT, CHILD = "base_link", "camera_color_optical_frame"


class HandEyeFileError(LocalizeError):
    """A file that does not hold the pose of a camera."""


class HandEye(NamedTuple):
    """Pose of the colour camera in the base frame.

    Attributes:
        T_base_camera: Maps colour camera (optical frame) to base coordinates, shape (4, 4).
        residual_px: Root mean square reprojection error of the marker's corners [px].
        residual_mm: The same at the marker's distance [mm].
        poses: Number of arm poses used.
        rotation_spread_deg: How far the arm turned about its second most turned axis [deg].
        date: When it was measured, as the caller wrote it.
    """

    T_base_camera: NDArray[np.float64]
    residual_px: float = float("nan")
    residual_mm: float = float("nan")
    poses: int = 0
    rotation_spread_deg: float = float("nan")
    date: str = ""


def hand_eye_from_pose(translation: ArrayLike, quaternion: ArrayLike, **about: object) -> HandEye:
    """A result of a translation [m], (3,), and a quaternion (x, y, z, w)."""
    return HandEye(transform_from(rotation_from_quaternion(quaternion), translation), **about)


def save_hand_eye(hand_eye: HandEye, path: Path | str) -> None:
    """Write a result; a file of that name is replaced in one step or not at all.

    Raises:
        HandEyeFileError: When the folder cannot be written.
    """
    path = Path(path)
    document = {
        "kind": KIND,
        "parent": PARENT,
        "child": CHILD,
        "translation": [float(value) for value in hand_eye.T_base_camera[:3, 3]],
        "quaternion_xyzw": [
            float(value) for value in quaternion_from_rotation(hand_eye.T_base_camera[:3, :3])
        ],
        "residual_px": float(hand_eye.residual_px),
        "residual_mm": float(hand_eye.residual_mm),
        "poses": int(hand_eye.poses),
        "rotation_spread_deg": float(hand_eye.rotation_spread_deg),
        "date": str(hand_eye.date),
    }
    text = "# Where the camera is: maps coordinates of `child` to `parent` [m].\n" + yaml.safe_dump(
        document, sort_keys=False, default_flow_style=None
    )
    try:
        write_atomically(path, text)
    except OSError as error:
        raise HandEyeFileError(
            f"cannot write hand-eye file {path}: {error.strerror}; is the folder there?"
        ) from error


def load_hand_eye(path: Path | str) -> HandEye:
    """Read a result.

    Raises:
        HandEyeFileError: When the file is missing or is no hand-eye result.
    """
    advice = "make one with `bathbot calibrate hand-eye BAG --out FILE`"
    if not str(path):
        raise HandEyeFileError(f"parameter hand_eye is empty; {advice}")
    try:
        document = read_yaml(path)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is no text"
        raise HandEyeFileError(f"cannot read hand-eye file {path}: {reason}; {advice}") from error
    except yaml.YAMLError as error:
        raise HandEyeFileError(f"hand-eye file {path} is no YAML; {advice}") from error
    if not isinstance(document, dict) or document.get("kind") != KIND:
        found = document.get("kind") if isinstance(document, dict) else type(document).__name__
        raise HandEyeFileError(f"hand-eye file {path} is of kind {found!r}, expected {KIND!r}; {advice}")
    if (document.get("parent"), document.get("child")) != (PARENT, CHILD):
        raise HandEyeFileError(
            f"hand-eye file {path} maps {document.get('child')} to {document.get('parent')}, "
            f"expected {CHILD} to {PARENT}; {advice}"
        )
    translation = _numbers(document, "translation", 3, path)
    quaternion = _numbers(document, "quaternion_xyzw", 4, path)
    if abs(np.linalg.norm(quaternion) - 1.0) > 1e-3 or np.abs(translation).max() > 10.0:
        raise HandEyeFileError(
            f"hand-eye file {path} holds translation {translation} m and quaternion {quaternion}, "
            f"which is no pose of a camera beside an arm; {advice}"
        )
    about = {name: document[name] for name in HandEye._fields[1:] if name in document}
    return hand_eye_from_pose(translation, quaternion, **about)


def _numbers(document: dict, key: str, count: int, path: Path | str) -> list[float]:
    values = document.get(key)
    sound = isinstance(values, list) and len(values) == count
    if not (sound and all(isinstance(v, int | float) and np.isfinite(v) for v in values)):
        raise HandEyeFileError(f"hand-eye file {path}: {key} must be {count} numbers, got {values!r}")
    return [float(value) for value in values]
