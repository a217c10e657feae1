"""Camera images, depths, points and bounding boxes as ROS messages."""

from __future__ import annotations

import array
import io
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import CameraModel
from teleopctl.sim.cameras.lens import fisheye_coefficients, undistorted

_Image = get_message("sensor_msgs/msg/Image")
_CompressedImage = get_message("sensor_msgs/msg/CompressedImage")
_CameraInfo = get_message("sensor_msgs/msg/CameraInfo")
_PointCloud2 = get_message("sensor_msgs/msg/PointCloud2")
_PointField = get_message("sensor_msgs/msg/PointField")

_FLOAT32 = 7
_POINT_BYTES = 16
# compressed_depth_image_transport's defaults, which its subscribers read from the message: depths
# are stored as a / z + b, in whole numbers; with b, the largest depth becomes 1.
_COMPRESSED_DEPTH_MAX_M = 10.0
_DEPTH_QUANTIZATION = 100.0
_INVERSE_DEPTH = 0
_DEPTH_HEADER = struct.Struct("<iff")
_MOST_UINT16 = 65535


# Any, here and below: classes that are made from their definitions.
def new_image(camera: CameraModel, encoding: str, pixel_bytes: int) -> Any:
    """Return a black sensor_msgs/Image of a camera's size and frame, to be filled repeatedly."""
    step = pixel_bytes * camera.width
    image = _Image(height=camera.height, width=camera.width, encoding=encoding, step=step)
    image.header.frame_id = camera.frame_id
    image.data = array.array("B", bytes(step * camera.height))
    return image


def pixels_of(image: Any, kind: type[np.generic], parts: int = 1) -> npt.NDArray[Any]:
    """Return a writable array view of an Image message's data, with ``parts`` values per pixel."""
    shape = (image.height, image.width, parts) if parts > 1 else (image.height, image.width)
    return np.frombuffer(image.data, kind).reshape(shape)


def new_info(camera: CameraModel) -> Any:
    """Return the sensor_msgs/CameraInfo of a camera, without a stamp."""
    lens = camera.lens
    info = _CameraInfo(
        height=camera.height,
        width=camera.width,
        distortion_model="plumb_bob" if lens is None else "equidistant",
        d=list(camera.distortion if lens is None else fisheye_coefficients(camera, lens)),
        k=camera.intrinsics,
        r=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        p=camera.projection,
    )
    info.header.frame_id = camera.frame_id
    return info


def new_compressed(camera: CameraModel) -> Any:
    """Return an empty sensor_msgs/CompressedImage in a camera's frame."""
    message = _CompressedImage()
    message.header.frame_id = camera.frame_id
    return message


def compress(message: Any, picture: npt.NDArray[np.uint8], how: str, jpeg_quality: int) -> None:
    """Write an RGB array as JPEG or PNG into a CompressedImage, as image_transport does.

    Args:
        message: The CompressedImage to fill.
        picture: RGB image, (height, width, 3).
        how: File format, ``jpeg`` or ``png``.
        jpeg_quality: Quality of JPEG files, 1 to 100.
    """
    from PIL import Image

    file = io.BytesIO()
    options = {"quality": jpeg_quality} if how == "jpeg" else {"compress_level": 3}
    Image.fromarray(picture).save(file, how, **options)
    # The second order of colours is that of OpenCV, as in image_transport; both file formats define
    # their own.
    message.format = f"rgb8; {how} compressed bgr8"
    message.data = array.array("B", file.getvalue())


def compress_depths(message: Any, depths: npt.NDArray[np.float32]) -> None:
    """Write depths up to 10 m as PNG into a CompressedImage, in image_transport's compressedDepth.

    Args:
        message: The CompressedImage to fill.
        depths: Depths in metres; those that are not finite are stored as not measured.
    """
    from PIL import Image

    scale = _DEPTH_QUANTIZATION * (_DEPTH_QUANTIZATION + 1.0)
    offset = 1.0 - scale / _COMPRESSED_DEPTH_MAX_M
    kept = np.isfinite(depths) & (depths > 0.0)
    inverse = np.zeros(depths.shape, np.float32)
    np.divide(scale, depths, out=inverse, where=kept)
    inverse[kept] += offset
    # Depths outside the range of the integers are stored as not measured.
    kept &= (inverse >= 1.0) & (inverse <= _MOST_UINT16)
    file = io.BytesIO()
    Image.fromarray(np.where(kept, inverse, 0.0).astype(np.uint16)).save(
        file, "png", compress_level=1
    )
    header = _DEPTH_HEADER.pack(_INVERSE_DEPTH, scale, offset)
    message.format = "32FC1; compressedDepth png"
    message.data = array.array("B", header + file.getvalue())


def new_points(camera: CameraModel) -> Any:
    """Return a sensor_msgs/PointCloud2 with one coloured point per pixel, to be filled."""
    names = ("x", "y", "z", "rgb")
    cloud = _PointCloud2(
        height=camera.height,
        width=camera.width,
        fields=[
            _PointField(name=name, offset=4 * place, datatype=_FLOAT32, count=1)
            for place, name in enumerate(names)
        ],
        point_step=_POINT_BYTES,
        row_step=_POINT_BYTES * camera.width,
        is_dense=False,
    )
    cloud.header.frame_id = camera.frame_id
    cloud.data = array.array("B", bytes(_POINT_BYTES * camera.width * camera.height))
    return cloud


class Rectifier:
    """Directions X/Z and Y/Z of a camera's pixels, to compute points from depths.

    Args:
        camera: Camera of the pixels.

    Attributes:
        x: X/Z of each pixel in the optical frame, (height, width).
        y: Y/Z of each pixel in the optical frame, (height, width).
    """

    def __init__(self, camera: CameraModel) -> None:
        x, y, _ = undistorted(camera)
        self.x = x.astype(np.float32)
        self.y = y.astype(np.float32)

    def fill(
        self, cloud: Any, depths: npt.NDArray[np.float32], picture: npt.NDArray[np.uint8]
    ) -> None:
        """Fill a PointCloud2 with coloured points in the optical frame (m); NaN for no depth."""
        points = np.frombuffer(cloud.data, np.float32).reshape(*depths.shape, 4)
        z = np.where(np.isfinite(depths), depths, np.float32(np.nan))
        np.multiply(self.x, z, out=points[..., 0])
        np.multiply(self.y, z, out=points[..., 1])
        points[..., 2] = z
        # PCL's order: blue, green, red from the lowest byte on.
        colours = points.view(np.uint8)[..., 12:15]
        colours[:] = picture[..., ::-1]


_GREEN = (0, 255, 0)


class PixelBox(NamedTuple):
    """Bounding box of one label in an image, in pixels, edges included."""

    label: int
    left: int
    top: int
    right: int
    bottom: int


def label_boxes(labels: npt.NDArray[np.uint16]) -> Iterator[PixelBox]:
    """Yield the bounding box of each label in a label image, except of background label 0.

    Args:
        labels: Index of the body that each pixel shows, (height, width); 0 for the background.
    """
    for label in np.unique(labels):
        if label:
            mask = labels == label
            columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
            yield PixelBox(int(label), *map(int, (columns[0], rows[0], columns[-1], rows[-1])))


# Any, here and below: classes that are made from their definitions.
def new_boxes(frame_id: str) -> Any:
    """Return an empty vision_msgs/Detection2DArray in a frame."""
    message = get_message("vision_msgs/msg/Detection2DArray")()
    message.header.frame_id = frame_id
    return message


def fill_boxes(message: Any, boxes: list[PixelBox]) -> None:
    """Set the detections of a Detection2DArray from pixel boxes."""
    detection = get_message("vision_msgs/msg/Detection2D")
    result = get_message("vision_msgs/msg/ObjectHypothesisWithPose")
    message.detections = []
    for box in boxes:
        found = detection(header=message.header, results=[result()])
        found.results[0].hypothesis.class_id = str(box.label)
        found.results[0].hypothesis.score = 1.0
        middle = found.bbox.center.position
        middle.x, middle.y = (box.left + box.right) / 2.0, (box.top + box.bottom) / 2.0
        found.bbox.size_x = box.right - box.left + 1.0
        found.bbox.size_y = box.bottom - box.top + 1.0
        message.detections.append(found)


def draw_boxes(picture: npt.NDArray[np.uint8], boxes: list[PixelBox]) -> None:
    """Draw green outlines of boxes, one pixel wide, into an RGB image in place."""
    for _, left, top, right, bottom in boxes:
        picture[[top, bottom], left : right + 1] = _GREEN
        picture[top : bottom + 1, [left, right]] = _GREEN
