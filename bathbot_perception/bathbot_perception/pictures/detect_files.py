"""Skin regions of pictures, folders and films on disk: drawn copies and one table."""

import csv
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.detection.detector import Detector
from bathbot_perception.errors import PictureError
from bathbot_perception.pictures.draw import draw_regions
from bathbot_perception.pictures.pictures import read_picture
from bathbot_perception.pictures.voc import PICTURE_SUFFIXES
from bathbot_perception.regions import Region

FILM_SUFFIXES = (".mp4", ".avi", ".mov", ".mkv", ".webm")
COLUMNS = ("source", "frame", "class", "score", "left", "top", "right", "bottom")


class Found(NamedTuple):
    """Regions of one picture or of one frame of a film (`frame` counts from 0; -1 for pictures).

    Where `error` is not empty nothing was detected and it says why, on one line.
    """

    source: Path
    frame: int
    regions: tuple[Region, ...]
    note: str = ""
    error: str = ""


def detect_files(paths: Iterable[Path], detector: Detector, out: Path | None = None) -> Iterator[Found]:
    """Detect in files and folders, one result at a time.

    With `out`, a drawn copy of each picture (JPEG) and film (MP4) and a table `regions.csv` are
    written there. A file that cannot be used gives a result with `error`; the rest goes on.

    Args:
        paths: Pictures, films, or folders (searched for both, not deeper).
        detector: From `detector.load`.
        out: Folder for drawn copies; made if it is missing.
    """
    if out is None:
        for path in files_of(paths):
            for found, _ in _frames(path, detector):
                yield found
        return
    out.mkdir(parents=True, exist_ok=True)
    names: set[str] = set()
    with (out / "regions.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for path in files_of(paths):
            name = _free_name(path.stem, names)
            yield from _record(path, detector, out / name, table)


def files_of(paths: Iterable[Path]) -> Iterator[Path]:
    """The paths themselves, with each folder replaced by its pictures and films, sorted by name."""
    for path in paths:
        if path.is_dir():
            suffixes = (*PICTURE_SUFFIXES, *FILM_SUFFIXES)
            yield from sorted(item for item in path.iterdir() if item.suffix.lower() in suffixes)
        else:
            yield path


def _free_name(stem: str, taken: set[str]) -> str:
    name, count = stem, 1
    while name in taken:
        count += 1
        name = f"{stem}-{count}"
    taken.add(name)
    return name


def _record(path: Path, detector: Detector, target: Path, table: "csv.Writer") -> Iterator[Found]:
    film = None
    for found, rgb in _frames(path, detector):
        for region in found.regions:
            box = (f"{value:.1f}" for value in region.box)
            table.writerow([found.source, found.frame, region.name, f"{region.score:.3f}", *box])
        if rgb is not None:
            drawn = cv2.cvtColor(draw_regions(rgb, found.regions), cv2.COLOR_RGB2BGR)
            if found.frame < 0:
                _write_picture(target.with_name(f"{target.name}.jpg"), drawn)
            else:
                film = film or _open_film(target.with_name(f"{target.name}.mp4"), path, drawn)
                film.write(drawn)
        yield found
    if film is not None:
        film.release()


def _write_picture(path: Path, bgr: NDArray[np.uint8]) -> None:
    if not cv2.imwrite(str(path), bgr):
        raise PictureError(f"cannot write {path}; is the folder writable and the disk not full?")


def _open_film(path: Path, source: Path, bgr: NDArray[np.uint8]) -> cv2.VideoWriter:
    rate = cv2.VideoCapture(str(source)).get(cv2.CAP_PROP_FPS) or 30.0
    return cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), rate, (bgr.shape[1], bgr.shape[0]))


def _frames(path: Path, detector: Detector) -> Iterator[tuple[Found, NDArray[np.uint8] | None]]:
    if path.suffix.lower() in FILM_SUFFIXES:
        yield from _film_frames(path, detector)
        return
    try:
        picture = read_picture(path)
    except PictureError as error:
        yield Found(path, -1, (), error=str(error)), None
        return
    yield Found(path, -1, tuple(detector.detect(picture.rgb)), note=picture.note), picture.rgb


def _film_frames(path: Path, detector: Detector) -> Iterator[tuple[Found, NDArray[np.uint8] | None]]:
    film = cv2.VideoCapture(str(path))
    frame = 0
    try:
        while True:
            whole, bgr = film.read()
            if not whole:
                break
            rgb = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
            yield Found(path, frame, tuple(detector.detect(rgb))), rgb
            frame += 1
    finally:
        film.release()
    if frame == 0:
        yield Found(path, 0, (), error=f"cannot read {path} as a film; is the file whole?"), None
