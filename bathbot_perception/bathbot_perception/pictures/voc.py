"""PASCAL VOC: one XML file of labelled boxes per picture, as LabelImg writes it (section 2.1.1.1)."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from bathbot_perception.classes import BACKGROUND, LABELS
from bathbot_perception.errors import AnnotationError
from bathbot_perception.regions import Region

PICTURE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff")
"""Endings of the picture files a data set may hold, in order of preference."""


class Annotation(NamedTuple):
    """The labelled boxes of one picture; every `Region.score` is 1.

    `difficult` are the boxes marked so: what they hold can hardly be told. As in the PASCAL VOC challenge, a
    detector neither gains by finding them nor loses by missing them.
    """

    filename: str
    width: int
    height: int
    regions: tuple[Region, ...]
    difficult: tuple[Region, ...] = ()


class Sample(NamedTuple):
    """A picture of a data set and the file of its boxes."""

    picture: Path
    annotation: Path


def read_annotation(path: Path) -> Annotation:
    """Read one VOC file. Boxes are cut at the picture's borders.

    Raises:
        AnnotationError: If the file is no VOC file, a class is unknown or a box is empty.
    """
    try:
        root = ElementTree.parse(path).getroot()
        width, height = (int(float(_text(root, f"size/{key}"))) for key in ("width", "height"))
        if width <= 0 or height <= 0:
            raise ValueError(f"its size is {width}x{height}")
        objects = [(_difficult(node), _region(node, width, height)) for node in root.findall("object")]
    except (OSError, ElementTree.ParseError, ValueError) as error:
        raise AnnotationError(
            f"cannot use {path} as PASCAL VOC: {error}; rewrite it with LabelImg"
        ) from error
    filename = root.findtext("filename") or path.stem
    plain, difficult = (
        tuple(region for hard, region in objects if hard == wanted and region.name != BACKGROUND)
        for wanted in (False, True)
    )
    return Annotation(filename, width, height, plain, difficult)


def check_size(sample: Sample, annotation: Annotation, shape: tuple[int, ...]) -> None:
    """Refuse boxes that were drawn on a picture of another size.

    Raises:
        AnnotationError: If the picture, of `shape` (height, width, ...) [px], is not as annotated.
    """
    height, width = shape[:2]
    if (width, height) != (annotation.width, annotation.height):
        raise AnnotationError(
            f"{sample.picture} is {width}x{height} px, not {annotation.width}x{annotation.height} as "
            f"{sample.annotation.name} says; were the boxes drawn on another copy?"
        )


def _text(node: ElementTree.Element, key: str) -> str:
    text = node.findtext(key)
    if text is None:
        raise ValueError(f"it has no <{key}>")
    return text


def _difficult(node: ElementTree.Element) -> bool:
    said = (node.findtext("difficult") or "0").strip()
    if said not in ("0", "1"):
        raise ValueError(f"<difficult> is {said!r}, want 0 or 1")
    return said == "1"


def _region(node: ElementTree.Element, width: int, height: int) -> Region:
    name = _text(node, "name")
    if name not in LABELS:
        raise ValueError(f"unknown class {name!r}, expected one of {', '.join(LABELS)}")
    left, top, right, bottom = (
        float(_text(node, f"bndbox/{key}")) for key in ("xmin", "ymin", "xmax", "ymax")
    )
    box = (max(left, 0.0), max(top, 0.0), min(right, float(width)), min(bottom, float(height)))
    if not (box[2] > box[0] and box[3] > box[1]):
        raise ValueError(
            f"the box {left:g}, {top:g}, {right:g}, {bottom:g} of {name} is empty or outside the picture"
        )
    return Region(name, 1.0, box)


def write_annotation(path: Path, annotation: Annotation) -> None:
    """Write one VOC file, coordinates to the nearest hundredth of a pixel."""
    root = ElementTree.Element("annotation")
    ElementTree.SubElement(root, "filename").text = annotation.filename
    size = ElementTree.SubElement(root, "size")
    for key, value in (("width", annotation.width), ("height", annotation.height), ("depth", 3)):
        ElementTree.SubElement(size, key).text = str(value)
    marked = [("0", region) for region in annotation.regions] + [("1", r) for r in annotation.difficult]
    for difficult, region in marked:
        node = ElementTree.SubElement(root, "object")
        ElementTree.SubElement(node, "name").text = region.name
        ElementTree.SubElement(node, "difficult").text = difficult
        corners = ElementTree.SubElement(node, "bndbox")
        for key, value in zip(("xmin", "ymin", "xmax", "ymax"), region.box, strict=True):
            ElementTree.SubElement(corners, key).text = f"{value:.2f}".rstrip("0").rstrip(".")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8")


def list_samples(folder: Path) -> list[Sample]:
    """Pair `images/*` with `annotations/*.xml` of a data set, sorted by name.

    Raises:
        AnnotationError: If a folder is missing, nothing is in it, or a picture lacks its boxes.
    """
    images, annotations = folder / "images", folder / "annotations"
    for part in (images, annotations):
        if not part.is_dir():
            raise AnnotationError(
                f"{folder} is no data set: it has no folder {part.name}/ (want images/ and annotations/)"
            )
    pictures = sorted(p for p in images.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES)
    if not pictures:
        raise AnnotationError(f"{images} holds no picture ({', '.join(PICTURE_SUFFIXES)})")
    samples = [Sample(picture, annotations / f"{picture.stem}.xml") for picture in pictures]
    missing = [sample.picture.name for sample in samples if not sample.annotation.is_file()]
    if missing:
        raise AnnotationError(
            f"{len(missing)} pictures of {folder} have no annotations/*.xml, the first is {missing[0]}"
        )
    return samples


def read_checked(folder: Path) -> frozenset[str]:
    """Stems of the pictures whose boxes a person has checked: the lines of `checked.txt`.

    Without that file every picture counts as checked.
    """
    listing = folder / "checked.txt"
    if not listing.is_file():
        return frozenset(sample.picture.stem for sample in list_samples(folder))
    return _stems(listing.read_text(encoding="utf-8").splitlines())


def _stems(lines: Iterable[str]) -> frozenset[str]:
    return frozenset(Path(line.strip()).stem for line in lines if line.strip())
