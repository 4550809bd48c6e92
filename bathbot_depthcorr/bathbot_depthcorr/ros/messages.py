"""Depth, colour, intrinsics and times to and from ROS messages; inside the program all is SI and NaN."""

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros.image_decoding import (
    MessageError,
    colour_from_image,
    depth_from_image,
    pinhole_from_info,
    stamp_seconds,
    transform_from_extrinsics,
)
from bathbot_depthcorr.ros.serialized_image import SerializedImage

__all__ = [
    "DepthImage", "MessageError", "colour_from_image", "depth_from_image", "extrinsics_from_transform",
    "header_of", "image_from_colour", "image_from_depth", "image_mm_from_depth", "info_from_pinhole",
    "pinhole_from_info", "stamp_from_seconds", "stamp_seconds", "transform_from_extrinsics",
]  # fmt: skip


def _image(pixels: NDArray, encoding: str, header: Header) -> Image:
    pixels = np.ascontiguousarray(pixels)
    height, width = pixels.shape[:2]
    image = Image(
        header=header, height=height, width=width, encoding=encoding, step=pixels.nbytes // max(height, 1)
    )
    image.data.frombytes(memoryview(pixels).cast("B"))  # the setter would copy once more
    return image


class DepthImage:
    """A 32FC1 image to publish again and again, so that no frame needs new memory.

    Attributes:
        depth: The image's own pixels [m], shape (H, W), NaN = none; write here.
        message: The image.
    """

    def __init__(self, height: int, width: int) -> None:
        """Make an image without depth."""
        self.message = _image(np.full((height, width), np.nan, "<f4"), "32FC1", Header())
        self.depth = np.frombuffer(self.message.data, "<f4").reshape(height, width)


def image_from_depth(depth: NDArray, header: Header) -> Image:
    """A 32FC1 image of depth [m], shape (H, W), NaN = none."""
    return _image(np.asarray(depth, dtype="<f4"), "32FC1", header)


def image_mm_from_depth(depth: NDArray, header: Header) -> Image:
    """A 16UC1 image [mm], 0 = none, of depth [m], shape (H, W); beyond 65.535 m there is none."""
    mm = np.asarray(depth, dtype=np.float32) * np.float32(1000.0) + np.float32(0.5)
    return _image(np.where((mm >= 1.0) & (mm < 65536.0), mm, 0.0).astype("<u2"), "16UC1", header)


def image_from_colour(rgb: NDArray[np.uint8], header: Header) -> Image:
    """An rgb8 image of colours, shape (H, W, 3)."""
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3:
        raise MessageError(f"colours must be uint8 with shape (H, W, 3), got {rgb.dtype} {rgb.shape}")
    return _image(rgb, "rgb8", header)


def info_from_pinhole(pinhole: Pinhole, header: Header) -> CameraInfo:
    """The camera_info that describes `pinhole`."""
    info = CameraInfo(header=header, width=pinhole.width, height=pinhole.height, distortion_model="plumb_bob")
    info.d = [float(value) for value in pinhole.coefficients]
    info.k = [float(value) for value in pinhole.matrix.ravel()]
    info.r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    info.p = [float(value) for value in np.column_stack([pinhole.matrix, np.zeros(3)]).ravel()]
    return info


def extrinsics_from_transform(transform: NDArray) -> Extrinsics:
    """The Extrinsics of a transform, shape (4, 4): RealSense writes the rotation column by column."""
    rotation = [float(value) for value in np.asarray(transform)[:3, :3].T.ravel()]
    return Extrinsics(rotation=rotation, translation=[float(value) for value in np.asarray(transform)[:3, 3]])


def header_of(image: SerializedImage) -> Header:
    """The std_msgs/Header of an image that was read in place."""
    stamp, frame_id = image.header
    return Header(stamp=Time(sec=stamp.sec, nanosec=stamp.nanosec), frame_id=frame_id)


def stamp_from_seconds(seconds: float) -> Time:
    """A builtin_interfaces/Time of seconds [s]."""
    nanoseconds = round(seconds * 1e9)
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)
