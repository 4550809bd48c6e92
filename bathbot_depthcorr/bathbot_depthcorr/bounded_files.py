"""Files that a stranger may have made: read without code in them, and never more than fits."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

_LARGEST_TEXT = 256 << 10  # [bytes]; our largest file has 10 kB
_LARGEST_ARRAYS = 512 << 20  # [bytes] that an archive may unfold to
_DEEPEST, _MOST_PARTS = 20, 50_000  # levels and parts of a YAML document
_OPENING = (yaml.MappingStartEvent, yaml.SequenceStartEvent)
_CLOSING = (yaml.MappingEndEvent, yaml.SequenceEndEvent)


def read_yaml(path: Path | str) -> Any:
    """Read one YAML document of a file.

    Raises:
        OSError: When it cannot be read.
        UnicodeDecodeError: When it is no text.
        yaml.YAMLError: When it is no YAML, or more than it should be.
    """
    with Path(path).open("rb") as file:
        data = file.read(_LARGEST_TEXT + 1)
    if len(data) > _LARGEST_TEXT:
        raise yaml.YAMLError(f"it is larger than {_LARGEST_TEXT >> 10} kB")
    return parse_yaml(data.decode("utf-8"))


def parse_yaml(text: str) -> Any:
    """Read one YAML document; a few lines of aliases can stand for gigabytes: what they unfold to counts.

    Raises:
        yaml.YAMLError: When it is no YAML, unfolds to too many parts, or is nested deeper than 20 levels.
    """
    sizes: dict[str, int] = {}  # parts behind each name
    open_parts: list[tuple[str | None, int]] = []  # names of those not closed yet, and parts before them
    parts = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        if isinstance(event, yaml.AliasEvent):
            parts += sizes.get(event.anchor, _MOST_PARTS)  # one that is not closed yet holds itself
        elif isinstance(event, _OPENING):
            open_parts.append((event.anchor, parts))
            parts += 1
        elif isinstance(event, _CLOSING):
            name, before = open_parts.pop()
            if name:
                sizes[name] = parts - before
        elif isinstance(event, yaml.ScalarEvent):
            parts += 1
            if event.anchor:
                sizes[event.anchor] = 1
        if parts > _MOST_PARTS or len(open_parts) > _DEEPEST:
            raise yaml.YAMLError(
                f"it unfolds to more than {_MOST_PARTS} parts, or is nested deeper than {_DEEPEST} levels"
            )
    return yaml.load(text, Loader=yaml.CSafeLoader)


def read_npz(path: Path | str) -> dict[str, NDArray[Any]]:
    """Read all arrays of an .npz file.

    Raises:
        OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error: As numpy does; ValueError also when
            it would unfold to more than half a gigabyte.
    """
    with zipfile.ZipFile(path) as archive:
        unfolded = sum(part.file_size for part in archive.infolist())
    if unfolded > _LARGEST_ARRAYS:
        raise ValueError(f"it unfolds to {unfolded >> 20} MB, more than {_LARGEST_ARRAYS >> 20} MB")
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}
