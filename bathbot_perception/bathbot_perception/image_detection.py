"""From a camera's message to detections: all that the node does with a picture but hearing and publishing."""

from typing import Any

from bathbot_perception.detector import Detector
from bathbot_perception.messages import DetectionMessages, colour_from_image
from bathbot_perception.smoothing import Smoothing


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
