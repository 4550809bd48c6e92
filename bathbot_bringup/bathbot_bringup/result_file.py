"""Numbers as JSON files that any reader takes: no NaN, written whole."""

import json
import math
from pathlib import Path
from typing import Any

from bathbot_bringup.atomic_file import write_atomically


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
    write_atomically(path, json.dumps(plain(content), indent=2, allow_nan=False) + "\n")
