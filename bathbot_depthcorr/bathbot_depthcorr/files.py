"""Files that are written whole or not at all: an interrupted write leaves the old file."""

import errno
import io
import os
import tempfile
from pathlib import Path
from typing import Any

from bathbot_depthcorr.errors import DepthcorrError

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}


class CalibrationFileError(DepthcorrError):
    """A file that is no depth correction, or cannot be written."""


def keep_private() -> None:
    """Have all that this process and its children write from now on be this user's: it may show a person."""
    os.umask(0o077)


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write beside the target and rename, so that no reader ever sees half a file; it is this user's only.

    Raises:
        OSError: When the folder is missing or cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_npz(path: Path, contents: dict[str, Any]) -> None:
    """Write named arrays to an .npz file.

    Raises:
        CalibrationFileError: When it cannot be written.
    """
    import numpy as np  # takes a tenth of a second, and every command loads this file

    packed = io.BytesIO()
    np.savez_compressed(packed, **contents)
    try:
        write_atomically(path, packed.getvalue())
    except OSError as error:
        advice = "is the disk full?" if error.errno in _FULL else "choose another folder"
        raise CalibrationFileError(f"cannot write {path}: {error.strerror}; {advice}") from error
