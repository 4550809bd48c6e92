"""Depth corrections on file: `load(path)` gives an object with `apply`, `sigma` and `T_colour_depth`."""

import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.bounded_files import read_npz
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.files import CalibrationFileError
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import rotation_angle
from bathbot_depthcorr.models.correction_model import FILE_FORMAT, Correction
from bathbot_depthcorr.models.table import MODELS


def load(path: Path | str) -> Correction:
    """Read a correction that `Correction.save` wrote.

    Raises:
        CalibrationFileError: If the file is missing, cut off, or something else.
    """
    path = Path(path)
    try:
        contents = read_npz(path)
    except FileNotFoundError as error:
        raise CalibrationFileError(
            f"no depth calibration at {path}; make one with: bathbot calibrate depth BAG --out {path}"
        ) from error
    except OSError as error:
        raise CalibrationFileError(
            f"cannot read {path}: {error.strerror or error}; is it a file of yours?"
        ) from error
    except (
        ValueError,
        EOFError,
        KeyError,
        TypeError,
        AttributeError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise CalibrationFileError(
            f"{path} ({path.stat().st_size} bytes) is no depth calibration or is cut off; calibrate again"
        ) from error
    return _build(path, contents)


def _build(path: Path, contents: dict[str, NDArray]) -> Correction:
    found = str(contents.get("format", "none"))
    if found != FILE_FORMAT:
        raise CalibrationFileError(f"{path} has format {found!r}, expected {FILE_FORMAT!r}; calibrate again")
    name = str(contents.get("model", "none"))
    if name not in MODELS:
        raise CalibrationFileError(
            f"{path} has model {name!r}, known are {', '.join(MODELS)}; update bathbot"
        )
    try:
        transform = np.array(contents["T_colour_depth"], dtype=float)
        if transform.shape != (4, 4) or not np.isfinite(rotation_angle(transform[:3, :3])):
            raise ValueError(f"T_colour_depth has shape {transform.shape}")
        width, height = (int(value) for value in contents["size"])
        camera = Pinhole(width, height, *(float(value) for value in contents["intrinsics"]))
        unit = CameraUnit(
            camera,
            transform,
            str(contents["serial"]),
            float(contents["temperature"]),
            float(contents["baseline"]),
        )
        return MODELS[name].kind.from_arrays(unit, contents)
    except (KeyError, ValueError, TypeError, IndexError, BathbotError) as error:
        raise CalibrationFileError(f"{path} lacks or garbles a value: {error}; calibrate again") from error
