"""A detected region of skin, as the localiser takes it from the detector."""

from typing import NamedTuple


class SkinRegion(NamedTuple):
    """A rectangle of skin in the colour picture.

    `box` is (left, top, right, bottom) [px] with (0, 0) at the picture's upper left corner, so a
    box over the whole picture is (0, 0, width, height).
    """

    name: str
    score: float
    box: tuple[float, float, float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """Pixel coordinates (u, v) of the middle of the box, the paper's target point (section 3.2).

        Half a pixel is taken off: a camera model counts from the centre of pixel (0, 0).
        """
        left, top, right, bottom = self.box
        return (left + right) / 2.0 - 0.5, (top + bottom) / 2.0 - 0.5
