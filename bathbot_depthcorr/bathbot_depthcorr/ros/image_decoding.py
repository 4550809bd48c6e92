"""The border where images become arrays: the only place that knows millimetres and "0 = no depth".

Works on any object with the fields of sensor_msgs/Image and sensor_msgs/CameraInfo, so live messages
and those read from a bag without ROS go through the same door.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.pinhole import Pinhole

_MM_PER_METRE = np.float32(1000.0)

RECTIFIED_MODELS = ("", "plumb_bob", "rational_polynomial", "brown_conrady", "inverse_brown_conrady")


class MessageError(DepthcorrError):
    """A message whose fields contradict each other or that holds another kind of data."""


def _rows(image: Any, dtype: np.dtype, channels: int) -> NDArray:
    """View an image's bytes as an array, shape (height, width, channels), whatever its row padding."""
    height, width, step = int(image.height), int(image.width), int(image.step)
    used = width * channels * dtype.itemsize
    data = np.frombuffer(image.data, np.uint8)
    if height == 0 or width == 0:
        raise MessageError(f"image is empty ({width}x{height}); is the camera streaming?")
    if step < used or data.size != step * height:
        raise MessageError(
            f"image {width}x{height} {image.encoding} has step {step} and {data.size} bytes, "
            f"expected step >= {used} and {step * height} bytes; is the message cut off?"
        )
    order = dtype.newbyteorder(">" if image.is_bigendian else "<")
    if step % dtype.itemsize == 0 and used == step:
        return data.view(order).reshape(height, width, channels)
    rows = data.reshape(height, step)[:, :used]
    return np.ascontiguousarray(rows).view(order).reshape(height, width, channels)


def depth_from_image(image: Any, out: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
    """Depth [m], shape (H, W), NaN = none, of a 16UC1 (millimetres, 0 = none) or 32FC1 (metres) image.

    Args:
        image: The message.
        out: Where to write, if it has the image's size; a new array otherwise.

    Raises:
        MessageError: If the encoding is no depth encoding or the size does not fit the data.
    """
    if image.encoding in ("16UC1", "mono16"):
        mm = _rows(image, np.dtype(np.uint16), 1)[..., 0]
        depth = np.divide(mm, _MM_PER_METRE, out=_fitting(out, mm.shape), dtype=np.float32)
        np.copyto(depth, np.nan, where=mm == 0)
        return depth
    if image.encoding == "32FC1":
        metres = _rows(image, np.dtype(np.float32), 1)[..., 0]
        depth = _fitting(out, metres.shape)
        np.copyto(depth, metres)
        np.copyto(depth, np.nan, where=~((depth > 0.0) & (depth < np.inf)))
        return depth
    raise MessageError(f"depth image has encoding {image.encoding!r}, expected 16UC1 or 32FC1; wrong topic?")


def _fitting(out: NDArray[np.float32] | None, shape: tuple[int, ...]) -> NDArray[np.float32]:
    return out if out is not None and out.shape == shape else np.empty(shape, np.float32)


def colour_from_image(image: Any) -> NDArray[np.uint8]:
    """Colours RGB, shape (H, W, 3), of an rgb8 or bgr8 image (rgb8: a view of the message's bytes).

    Raises:
        MessageError: If the encoding is another one or the size does not fit the data.
    """
    if image.encoding == "rgb8":
        return _rows(image, np.dtype(np.uint8), 3)
    if image.encoding == "bgr8":
        return np.ascontiguousarray(_rows(image, np.dtype(np.uint8), 3)[..., ::-1])
    raise MessageError(f"colour image has encoding {image.encoding!r}, expected rgb8 or bgr8; wrong topic?")


def pinhole_from_info(info: Any) -> Pinhole:
    """Intrinsics of a sensor_msgs/CameraInfo.

    Raises:
        MessageError: On a lens model that Eq. (5) with Brown-Conrady distortion does not describe.
        InvalidIntrinsicsError: On numbers that describe no camera.
    """
    if info.distortion_model not in RECTIFIED_MODELS:
        raise MessageError(
            f"camera_info has distortion model {info.distortion_model!r}, expected plumb_bob; "
            "is this camera a fisheye?"
        )
    distortion = tuple(float(value) for value in info.d)
    if not any(distortion):
        distortion = ()
    elif len(distortion) != 5:
        raise MessageError(f"camera_info has {len(distortion)} distortion coefficients, expected 0 or 5")
    k = [float(value) for value in info.k]
    return Pinhole(int(info.width), int(info.height), k[0], k[4], k[2], k[5], distortion)


def transform_from_extrinsics(extrinsics: Any) -> NDArray[np.float64]:
    """Transform, shape (4, 4), of a realsense2_camera_msgs/Extrinsics (column-major rotation).

    Raises:
        MessageError: If the nine numbers are no rotation.
    """
    transform = np.eye(4)
    rotation = np.asarray(extrinsics.rotation, dtype=float).reshape(3, 3).T
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3) or np.linalg.det(rotation) < 0.0:
        raise MessageError(f"extrinsics hold no rotation: {np.round(rotation, 4).tolist()}")
    transform[:3, :3] = rotation
    transform[:3, 3] = extrinsics.translation
    return transform


def stamp_seconds(stamp: Any) -> float:
    """Seconds [s] of a builtin_interfaces/Time."""
    return stamp.sec + 1e-9 * stamp.nanosec
