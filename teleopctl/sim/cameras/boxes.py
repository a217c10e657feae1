"""Boxes around what a camera sees, as ros_gz passes on those of Gazebo's boundingbox_camera."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from teleopctl.interfaces import get_message

_GREEN = (0, 255, 0)


class PixelBox(NamedTuple):
    """Pixel box of one label, inclusive."""

    label: int
    left: int
    top: int
    right: int
    bottom: int


def boxes_of(labels: npt.NDArray[np.uint16]) -> Iterator[PixelBox]:
    """Return the bounding box of each label in a picture.

    Args:
        labels: The number of the body that each pixel shows, (height, width); 0 for the background.
    """
    for label in np.unique(labels):
        if label:
            mask = labels == label
            columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
            yield PixelBox(int(label), *map(int, (columns[0], rows[0], columns[-1], rows[-1])))


# Any, here and below: classes that are made from their definitions.
def new_boxes(frame_id: str) -> Any:
    """Return a reusable detection message without boxes."""
    message = get_message("vision_msgs/msg/Detection2DArray")()
    message.header.frame_id = frame_id
    return message


def fill_boxes(message: Any, boxes: list[PixelBox]) -> None:
    """Fill a Detection2DArray; pixel (0, 0) is the centre of the upper left pixel."""
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
    """Draw the boxes into a picture, (height, width, 3), one pixel wide."""
    for _, left, top, right, bottom in boxes:
        picture[[top, bottom], left : right + 1] = _GREEN
        picture[top : bottom + 1, [left, right]] = _GREEN
