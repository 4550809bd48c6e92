"""Detection over whatever a user names: what perception reads from disk, and bags beside it."""

import csv
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
from bathbot_depthcorr.ros.bag_messages import is_bag
from bathbot_depthcorr.ros.image_decoding import colour_from_image
from bathbot_perception.detection.detector import Detector
from bathbot_perception.pictures.detect_files import COLUMNS, FILM_SUFFIXES, Found, detect_files, files_of
from bathbot_perception.pictures.draw import draw_regions
from bathbot_perception.pictures.voc import PICTURE_SUFFIXES

from bathbot_bringup.bag.reading import check_whole, read_messages, summarise_bag
from bathbot_bringup.errors import BagError, InputError

COLOUR_TOPIC = "color/image_raw"


def detect_paths(paths: Sequence[Path], detector: Detector, out: Path, every: int) -> Iterator[Found]:
    """Detect in pictures, films, folders and bags; write drawn copies and `regions.csv` to `out`.

    Nothing is left in `out` when nothing could be read.

    Args:
        paths: What to look at.
        detector: From `bathbot_perception.detection.detector.load`.
        out: Folder to write to.
        every: Of a bag, every so many-th picture.

    Raises:
        InputError: Names the first path that could not be used, after all others were done.
    """
    check_paths(paths)
    bags = [path for path in paths if is_bag(path)]
    for bag in bags:
        check_bag(bag)
    failures, done = [], 0
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as folder:
        building = Path(folder)
        for found in detect_files([path for path in paths if not is_bag(path)], detector, building):
            if found.error:
                failures.append(found.error)
            else:
                done += 1
                yield found
        for bag in bags:
            for found in detect_bag(bag, detector, building, every):
                done += 1
                yield found
        if done:
            out.mkdir(exist_ok=True)
            for file in building.iterdir():
                file.replace(out / file.name)
    if failures:
        more = f" (and {len(failures) - 1} more)" if len(failures) > 1 else ""
        raise InputError(failures[0] + more)


def check_paths(paths: Sequence[Path]) -> None:
    """Refuse paths that do not exist or hold nothing to look at.

    Raises:
        InputError: Names the first of them.
    """
    known = (*PICTURE_SUFFIXES, *FILM_SUFFIXES)
    for path in paths:
        if not path.exists():
            raise InputError(f"there is no {path}; give pictures, films, folders or bags")
        if path.is_dir() and not is_bag(path) and not any(files_of([path])):
            raise InputError(
                f"folder {path} holds no picture and no film; known endings are {', '.join(known)}"
            )


def check_bag(bag: Path) -> None:
    """Refuse a bag that is damaged, or without colour pictures.

    Raises:
        BagError: Says what the bag holds instead.
    """
    check_whole(bag)
    topics = [topic for topic in summarise_bag(bag) if topic.messages]
    if not any(topic.name.endswith(f"/{COLOUR_TOPIC}") for topic in topics):
        held = ", ".join(topic.name for topic in topics[:5]) or "nothing"
        raise BagError(
            f"bag {bag} holds no colour pictures, only {held}; the privacy profile metrics_only records "
            "none, record with --profile full and consent"
        )


def detect_bag(bag: Path, detector: Detector, out: Path, every: int) -> Iterator[Found]:
    """Detect in every so many-th colour picture of a bag; the table of `out` is continued."""
    table = out / "regions.csv"
    with table.open("a", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        if table.stat().st_size == 0:
            rows.writerow(COLUMNS)
        for frame, entry in enumerate(read_messages(bag, (COLOUR_TOPIC,))):
            if frame % every:
                continue
            rgb = colour_from_image(entry.message)
            regions = detector.detect(rgb)
            for region in regions:
                box = (f"{value:.1f}" for value in region.box)
                rows.writerow([bag, frame, region.name, f"{region.score:.3f}", *box])
            drawn = cv2.cvtColor(draw_regions(rgb, regions), cv2.COLOR_RGB2BGR)
            cv2.imwrite(str(out / f"{bag.stem}-{frame:05d}.jpg"), drawn)
            yield Found(bag, frame, tuple(regions))
