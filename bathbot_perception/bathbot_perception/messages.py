"""Between ROS messages and this package: colour images in, detections out.

Boxes keep this package's pixel coordinates: (0, 0) is the upper left corner of the picture.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import Header
from vision_msgs.msg import (
    Detection2D,
    Detection2DArray,
    LabelInfo,
    ObjectHypothesisWithPose,
    VisionClass,
)

from bathbot_perception.classes import LABELS
from bathbot_perception.detection.detector import Detector
from bathbot_perception.detection.smoothing import Smoothing
from bathbot_perception.errors import PictureError
from bathbot_perception.regions import Region


def colour_from_image(image: Any) -> NDArray[np.uint8]:
    """Colours RGB, shape (H, W, 3), of an image message with encoding rgb8 or bgr8.

    Raises:
        PictureError: On another encoding or when the data do not fill the picture.
    """
    if image.encoding not in ("rgb8", "bgr8"):
        raise PictureError(
            f"colour image has encoding {image.encoding!r}, expected rgb8 or bgr8; wrong topic?"
        )
    data = np.frombuffer(image.data, np.uint8)
    if (
        image.width == 0
        or image.step < 3 * image.width
        or data.size != image.step * image.height
        or data.size == 0
    ):
        raise PictureError(
            f"image is {image.width}x{image.height}, {image.step} bytes a row, but has {data.size}; cut off?"
        )
    pixels = data.reshape(image.height, image.step)[:, : 3 * image.width].reshape(
        image.height, image.width, 3
    )
    return pixels if image.encoding == "rgb8" else np.ascontiguousarray(pixels[..., ::-1])


class DetectionMessages:
    """Detections filled anew for every picture; making such messages takes several times longer."""

    def __init__(self) -> None:
        """Begin without any."""
        self._pool: list[Detection2D] = []

    def fill(self, regions: Sequence[Region], header: Header) -> Detection2DArray:
        """Detections with the header of their image, untouched; the next call changes the message."""
        while len(self._pool) < len(regions):
            self._pool.append(Detection2D(results=[ObjectHypothesisWithPose()]))
        used = self._pool[: len(regions)]
        for detection, region in zip(used, regions, strict=True):
            detection.header = header
            hypothesis, box = detection.results[0].hypothesis, detection.bbox
            hypothesis.class_id, hypothesis.score = region.name, region.score
            box.size_x, box.size_y = region.size
            box.center.position.x, box.center.position.y = region.centre
        return Detection2DArray(header=header, detections=used)


def regions_from_detections(message: Detection2DArray) -> list[Region]:
    """The inverse of `DetectionMessages.fill`; of several hypotheses the best counts."""
    regions = []
    for detection in message.detections:
        if not detection.results:
            continue
        best = max((result.hypothesis for result in detection.results), key=lambda item: item.score)
        centre, half = detection.bbox.center.position, (detection.bbox.size_x / 2, detection.bbox.size_y / 2)
        box = (centre.x - half[0], centre.y - half[1], centre.x + half[0], centre.y + half[1])
        regions.append(Region(best.class_id, best.score, box))
    return regions


def label_info(header: Header, threshold: float) -> LabelInfo:
    """All labels with their ids; the last, background, is never detected."""
    classes = [VisionClass(class_id=index, class_name=name) for index, name in enumerate(LABELS)]
    return LabelInfo(header=header, class_map=classes, threshold=threshold)


class ImageDetection:
    """A detector with its memory of the last picture."""

    def __init__(self, detector: Detector, smoothing: Smoothing) -> None:
        """Begin without a last picture."""
        self._detector, self._smoothing, self._messages = detector, smoothing, DetectionMessages()

    def detect(self, image: Any) -> Any:
        """Regions of bare skin as `Detection2DArray`, with the header of an `Image`, untouched.

        The next call changes the message.

        Raises:
            PictureError: On another encoding, or when the data do not fill the picture.
        """
        regions = self._smoothing.update(self._detector.detect(colour_from_image(image)))
        return self._messages.fill(regions, image.header)
