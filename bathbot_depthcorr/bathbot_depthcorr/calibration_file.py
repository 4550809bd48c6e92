"""Writing calibration files so that an interrupted write leaves the old one."""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from bathbot_depthcorr.errors import DepthcorrError


class CalibrationFileError(DepthcorrError):
    """A file that is no depth correction, or cannot be written."""


def write_atomically(path: Path, contents: dict[str, Any]) -> None:
    """Write an .npz file under a temporary name and move it into place."""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    except OSError as error:
        raise CalibrationFileError(f"cannot write {path}: {error.strerror}; choose another folder") from error
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, **contents)
        temporary.chmod(0o644)
        temporary.replace(path)
    except OSError as error:
        raise CalibrationFileError(f"cannot write {path}: {error.strerror}; is the disk full?") from error
    finally:
        temporary.unlink(missing_ok=True)
