"""Pictures from files: whole, colour, 8-bit, or refused with a reason."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from bathbot_perception.detection.letterbox import GREY
from bathbot_perception.errors import PictureError

LEAST_SIDE = 16
"""Pictures with a shorter side are refused [px]."""
MOST_PIXELS = 100_000_000
"""Pictures with more pixels are refused before they are decoded."""


class Picture(NamedTuple):
    """RGB, shape (h, w, 3), and what had to be done or should be known about it ("" if nothing)."""

    rgb: NDArray[np.uint8]
    note: str


def read_picture(path: Path) -> Picture:
    """Read a picture file, turned upright as its EXIF data say.

    Greyscale and 16-bit pictures are converted, transparency is laid on grey; the note says so.

    Raises:
        PictureError: If the file is cut off, no picture, too small or too large.
    """
    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None  # we refuse by our own rule below
    try:
        with Image.open(path) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise PictureError(
                    f"{path} is {width}x{height} px, over {MOST_PIXELS // 1_000_000} million; scale it down"
                )
            if min(width, height) < LEAST_SIDE:
                raise PictureError(f"{path} is {width}x{height} px; a side must have at least {LEAST_SIDE}")
            return _convert(ImageOps.exif_transpose(image))
    except PictureError:
        raise
    except Exception as error:  # broken files raise what they like: OSError, SyntaxError, struct.error
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PictureError(f"cannot read {path} as a picture: {reason}; is the file whole?") from error
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def _convert(image: Image.Image) -> Picture:
    notes = []
    if image.mode.startswith("I") or image.mode == "F":
        values = np.asarray(image, dtype=np.float64)
        notes.append("16-bit greyscale, scaled to 8 bit")
        image = Image.fromarray(np.clip(values / 257.0, 0, 255).astype(np.uint8))
    elif image.mode in ("1", "L", "LA"):
        notes.append("greyscale: regions are less sure")
    if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        layer = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", layer.size, (GREY, GREY, GREY, 255)), layer)
        notes.append("transparency laid on grey")
    rgb = np.asarray(image.convert("RGB"))
    if rgb.max() < 8:
        notes.append("all black")
    return Picture(np.ascontiguousarray(rgb), "; ".join(notes))
