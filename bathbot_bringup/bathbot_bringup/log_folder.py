"""A folder for the lines of processes, which stays only where somebody needs to read them."""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bathbot_bringup.errors import ProcessError


@contextmanager
def log_folder(purpose: str) -> Iterator[Path]:
    """Make a temporary folder; it is removed at the end unless a process failed, whose log it holds."""
    folder = Path(tempfile.mkdtemp(prefix=f"bathbot-{purpose}-"))
    keep = False
    try:
        yield folder
    except ProcessError:
        keep = True
        raise
    finally:
        if not keep:
            shutil.rmtree(folder, ignore_errors=True)
