"""Small notations of the command line, what is wrong with a bad one, and options that commands share."""

import os
import re
from collections.abc import Mapping
from pathlib import Path

import typer

from bathbot_bringup.errors import InputError

# Of the simulated camera, for every command that starts one.
RATE = typer.Option(5.0, help="Pictures per second of the simulated camera [Hz].")
PRESET = typer.Option("paper", help="Error model of the simulated depth camera: paper, yaw or good.")
CALIBRATION = typer.Option(
    None, help="Depth calibration of that camera; the one that comes with bathbot is for preset paper."
)


def writable(path: Path | None) -> Path | None:
    """A file that can be written when all is computed, which may take an hour; a callback of its option.

    Raises:
        InputError: When it cannot, now.
    """
    if path is None:
        return None
    there = next(folder for folder in (path.absolute(), *path.absolute().parents) if folder.exists())
    if path.is_dir():
        raise InputError(f"{path} is a folder; name a file in it")
    if there != path.absolute() and not there.is_dir():
        raise InputError(f"{path} cannot be written: {there} is no folder")
    if not os.access(there, os.W_OK):
        raise InputError(f"{path} cannot be written: {there} is not yours to change; choose another place")
    return path


def seed_list(text: str) -> list[int]:
    """Read seeds such as `3`, `0-19` or `0-4,7,9`; each once, in order.

    Raises:
        InputError: On anything else.
    """
    seeds: list[int] = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,9})(?:-(\d{1,9}))?\s*", part)
        if match is None:
            raise InputError(f"seeds are numbers and ranges such as 0-19 or 0-4,7, got {text!r}")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first or last - first >= 10000:
            raise InputError(
                f"the range {part.strip()} of seeds is empty or too long; write the smaller number first"
            )
        seeds += range(first, last + 1)
    return list(dict.fromkeys(seeds))


def name_list(text: str) -> list[str]:
    """Read names with commas between; none of an empty text."""
    return [name.strip() for name in text.split(",") if name.strip()]


def unused_folder(path: Path | None) -> Path | None:
    """Refuse a folder that holds something: nothing of an earlier run shall be lost, or taken for this one's.

    Raises:
        InputError: When it does.
    """
    if path is not None and path.exists() and not (path.is_dir() and not any(path.iterdir())):
        raise InputError(f"{path} is there already and no empty folder; name a new one, or remove it first")
    return path


def refuse_with(what: str, options: Mapping[str, object]) -> None:
    """Refuse options that mean nothing with another, or without it.

    Raises:
        InputError: When one of them was given.
    """
    for option, given in options.items():
        if given:
            raise InputError(f"{option} means nothing with {what}; leave it out")


def count_or_seeds(text: str) -> list[int]:
    """Read a number of seeds, `5` for 0 to 4, or the seeds themselves as `seed_list` does.

    Raises:
        InputError: On anything else, or no seed at all.
    """
    if not text.strip().isdecimal():
        return seed_list(text)
    if not 1 <= int(text) <= 10000:
        raise InputError(f"the number of seeds must lie between 1 and 10000, got {text}")
    return list(range(int(text)))


def board_size(text: str) -> tuple[int, int]:
    """Read the inner corners of a chessboard, such as `11x8`.

    Raises:
        InputError: On anything else.
    """
    match = re.fullmatch(r"(\d{1,2})x(\d{1,2})", text.strip())
    if match is None or min(int(match[1]), int(match[2])) < 2:
        raise InputError(f"a board is written as inner corners along x across, such as 11x8, got {text!r}")
    return int(match[1]), int(match[2])


def picture_size(text: str) -> tuple[int, int]:
    """Read the width and height of a picture [px], such as `848x480`.

    Raises:
        InputError: On anything else.
    """
    match = re.fullmatch(r"(\d{2,4})x(\d{2,4})", text.strip())
    if match is None:
        raise InputError(f"a size is written as width x height in pixels, such as 848x480, got {text!r}")
    return int(match[1]), int(match[2])
