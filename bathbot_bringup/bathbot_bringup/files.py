"""What a command leaves on disk: numbers as JSON that any reader takes (no NaN), pages, logs."""

import json
import math
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bathbot_depthcorr.files import write_atomically

from bathbot_bringup.errors import ProcessError


def write_file(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all; its folder is made if it does not exist.

    Raises:
        OSError: When the folder cannot be made or written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, content)


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


def clean_folders(older_than: float = 86400.0) -> int:
    """Remove temporary folders of `log_folder` that nobody touched for so long [s]; how many they were."""
    found = [
        folder
        for folder in Path(tempfile.gettempdir()).glob("bathbot-*-*")
        if folder.is_dir()
        and not folder.is_symlink()
        and folder.stat().st_uid == os.geteuid()
        and time.time() - max(path.stat().st_mtime for path in (folder, *folder.rglob("*"))) > older_than
    ]
    for folder in found:
        shutil.rmtree(folder, ignore_errors=True)
    return len(found)


def plain(value: Any) -> Any:
    """Turn a value into what JSON knows; numbers that do not exist (NaN, infinity) become null."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if hasattr(value, "item") and not isinstance(value, str):  # numpy scalars
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file in one step."""
    write_file(path, json.dumps(plain(content), indent=2, allow_nan=False) + "\n")
