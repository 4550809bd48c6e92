"""Plain folders of views whose true plane is known: a door for data that was not recorded with ROS.

`docs/depth_calibration.md` describes the format. One .npz file per pose; the camera in `camera.json` or
`camera.npz`, or in each file. Depth in whole numbers is millimetres, depth in floats metres.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.bounded_files import read_npz
from bathbot_depthcorr.errors import BathbotError, DepthcorrError
from bathbot_depthcorr.files import write_atomically, write_npz
from bathbot_depthcorr.geometry.camera_unit import DEFAULT_BASELINE, CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane, fit_plane
from bathbot_depthcorr.geometry.quality import plane_rmse
from bathbot_depthcorr.ros.bag_messages import is_bag
from bathbot_depthcorr.views.colour_reference import ViewSet
from bathbot_depthcorr.views.still_watch import mean_depth
from bathbot_depthcorr.views.views import CalibrationView, Steps

INTRINSICS = ("width", "height", "fx", "fy", "cx", "cy")
CAMERA_KEYS = (*INTRINSICS, "baseline", "T_colour_depth", "serial", "temperature")
PLANES = ("plane", "plane_depth", "true_depth")
MOST_BEND = 0.005  # [m] RMS of a true depth that is called a plane
LIKELY = 0.1, 20.0  # [m] between which the median of a depth image lies


class ViewFolderError(DepthcorrError):
    """A folder of views that is empty, damaged or contradicts itself."""


def is_view_folder(path: Path) -> bool:
    """Whether a folder holds .npz views and is no bag."""
    return path.is_dir() and not is_bag(path) and bool(_view_files(path))


def read_view_folder(folder: Path, steps: Steps = Steps()) -> ViewSet:
    """Read all views of a folder.

    Args:
        folder: With .npz files.
        steps: Hears how it goes.

    Raises:
        ViewFolderError: Naming the file and what is wrong with it.
    """
    files = _view_files(folder)
    if not files:
        raise ViewFolderError(f"{folder} holds no .npz views; see docs/depth_calibration.md for the format")
    common, unit, views = _camera_file(folder), None, []
    for number, path in enumerate(files, start=1):
        steps.progress(number / len(files), path.name)
        contents = _contents(path)
        try:
            camera = _unit({**common, **{key: contents[key] for key in CAMERA_KEYS if key in contents}})
            _refuse_other(unit, camera)
            unit = unit or camera
            views.append(_view(contents, unit))
        except BathbotError as error:
            raise ViewFolderError(f"{path}: {error}") from error
    return ViewSet(views, unit)


def write_view(path: Path, view: CalibrationView) -> None:
    """Write one view with its plane in the colour frame."""
    plane = np.append(view.plane.normal, view.plane.offset)
    noise = {"frame_count": view.frames, "temporal_noise": view.temporal_noise}
    write_npz(path, {"depth": view.depth, "plane": plane, "covariance": view.covariance, **noise})


def write_view_folder(folder: Path, found: ViewSet) -> None:
    """Write views and their camera; the folder is made if it does not exist."""
    folder.mkdir(parents=True, exist_ok=True)
    unit, camera = found.unit, found.unit.depth_camera
    known = {key: getattr(camera, key) for key in INTRINSICS}
    known |= {
        "baseline": unit.baseline,
        "T_colour_depth": unit.T_colour_depth.tolist(),
        "serial": unit.serial,
    }
    known |= {"temperature": unit.temperature} if np.isfinite(unit.temperature) else {}
    write_atomically(folder / "camera.json", json.dumps(known, indent=2) + "\n")
    for number, view in enumerate(found.views):
        write_view(folder / f"view_{number:03d}.npz", view)


def _view_files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("*.npz") if path.name != "camera.npz")


def _contents(path: Path) -> dict[str, NDArray]:
    try:
        return read_npz(path)
    except Exception as error:  # a damaged archive leads numpy to errors of any kind
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ViewFolderError(f"cannot read {path}: {reason}; is it a complete .npz file?") from error


def _camera_file(folder: Path) -> Mapping[str, Any]:
    """Contents of camera.json or camera.npz; empty if there is neither."""
    if (folder / "camera.npz").exists():
        return _contents(folder / "camera.npz")
    path = folder / "camera.json"
    if not path.exists():
        return {}
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ViewFolderError(f"cannot read {path}: {error}; it must be a JSON object") from error
    if not isinstance(found, dict):
        raise ViewFolderError(f"{path} holds a {type(found).__name__}, it must be a JSON object")
    return found


def _unit(known: Mapping[str, Any]) -> CameraUnit:
    lacking = [key for key in INTRINSICS if key not in known]
    if lacking:
        raise ViewFolderError(f"the camera's {', '.join(lacking)} are not given; write them to camera.json")
    fx, fy, cx, cy = (float(_numbers(known, key, ())) for key in INTRINSICS[2:])
    camera = Pinhole(int(_numbers(known, "width", ())), int(_numbers(known, "height", ())), fx, fy, cx, cy)
    transform = _numbers(known, "T_colour_depth", (4, 4)) if "T_colour_depth" in known else np.eye(4)
    turn = transform[:3, :3]
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-3) or np.linalg.det(turn) < 0.0:
        raise ViewFolderError(f"T_colour_depth holds no rotation: {np.round(turn, 4).tolist()}")
    baseline = float(_numbers(known, "baseline", ())) if "baseline" in known else DEFAULT_BASELINE
    if not 0.005 <= baseline <= 1.0:
        raise ViewFolderError(f"baseline must be 0.005 to 1 m, got {baseline}; give it in metres")
    temperature = float(_numbers(known, "temperature", ())) if "temperature" in known else float("nan")
    return CameraUnit(camera, transform, str(known.get("serial", "")), temperature, baseline)


def _refuse_other(unit: CameraUnit | None, camera: CameraUnit) -> None:
    if unit is None:
        return
    same = unit.depth_camera == camera.depth_camera and unit.serial == camera.serial
    if not (same and np.allclose(unit.T_colour_depth, camera.T_colour_depth, atol=1e-6)):
        first, other = (f"{one.serial or 'unnamed'} {one.depth_camera}" for one in (unit, camera))
        raise ViewFolderError(f"its camera, {other}, is not the first view's, {first}; use one camera")


def _view(contents: Mapping[str, NDArray], unit: CameraUnit) -> CalibrationView:
    size = unit.depth_camera.height, unit.depth_camera.width
    if ("depth" in contents) == ("frames" in contents):
        raise ViewFolderError(f"it must hold either depth or frames, it has {', '.join(sorted(contents))}")
    stack = contents["depth"][None] if "depth" in contents else contents["frames"]
    if stack.ndim != 3 or stack.shape[1:] != size or not len(stack):
        raise ViewFolderError(f"depth has shape {stack.shape[-2:]}, the camera has {size}; was it resized?")
    depth, frames, noise = mean_depth(list(_metres(stack)))
    covariance = _numbers(contents, "covariance", (3, 3)) if "covariance" in contents else np.zeros((3, 3))
    if {"frame_count", "temporal_noise"} <= set(contents):
        frames = max(1, int(_numbers(contents, "frame_count", ())))
        noise = float(_numbers(contents, "temporal_noise", ()))
    return CalibrationView(depth, _plane(contents, unit), covariance, frames, noise)


def _metres(stack: NDArray) -> NDArray[np.float32]:
    """Depth [m] with NaN for none, whatever it was written as."""
    whole = np.issubdtype(stack.dtype, np.integer)
    if not (whole or np.issubdtype(stack.dtype, np.floating)):
        raise ViewFolderError(f"depth has type {stack.dtype}; write uint16 [mm] or float32 [m]")
    metres = stack.astype(np.float32) * np.float32(0.001 if whole else 1.0)
    metres[~((metres > 0.0) & np.isfinite(metres))] = np.nan
    middle = float(np.nanmedian(metres)) if np.isfinite(metres).any() else 1.0
    if not LIKELY[0] <= middle <= LIKELY[1]:
        raise ViewFolderError(f"depth has a median of {middle:.3g} m; whole numbers are [mm], floats [m]")
    return metres


def _plane(contents: Mapping[str, NDArray], unit: CameraUnit) -> Plane:
    """The wall in the colour frame."""
    given = [name for name in PLANES if name in contents]
    if len(given) != 1:
        raise ViewFolderError(f"it must hold one of {', '.join(PLANES)}, it has {', '.join(given) or 'none'}")
    if given == ["true_depth"]:
        return _fitted(contents["true_depth"], unit).transformed(unit.T_colour_depth)
    values = _numbers(contents, given[0], (4,))
    length = float(np.linalg.norm(values[:3]))
    if length < 1e-6 or abs(values[3]) < 1e-6:
        raise ViewFolderError(f"{given[0]} {values.tolist()} is no wall before the camera; give n.x = d")
    values = values / (-np.sign(values[3]) * length)
    plane = Plane(values[:3], float(values[3]))
    return plane if given == ["plane"] else plane.transformed(unit.T_colour_depth)


def _fitted(true_depth: NDArray, unit: CameraUnit) -> Plane:
    """Plane in the depth frame of a true depth image."""
    camera = unit.depth_camera
    if true_depth.shape != (camera.height, camera.width):
        raise ViewFolderError(
            f"true_depth has shape {true_depth.shape}, the camera {(camera.height, camera.width)}"
        )
    points = camera.deproject(camera.pixel_grid(), _metres(true_depth))[::4, ::4]
    plane = fit_plane(points, robust=True)
    if (bend := plane_rmse(points, plane)) > MOST_BEND:
        raise ViewFolderError(
            f"true_depth is {bend * 1e3:.1f} mm RMS off its plane, at most {MOST_BEND * 1e3:.0f} are allowed"
        )
    return plane


def _numbers(known: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Finite numbers of one shape."""
    try:
        values = np.asarray(known[key], dtype=float)
    except (TypeError, ValueError) as error:
        raise ViewFolderError(f"{key} must be numbers of shape {shape}, got {known[key]!r}") from error
    if values.shape != shape or not np.isfinite(values).all():
        raise ViewFolderError(f"{key} must be finite and have shape {shape}, got {values.tolist()}")
    return values
