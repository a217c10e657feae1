"""``ros2_numpy.image``. Images as arrays of height, width and channels, if several."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from cv_bridge import CvBridge

from ros2_numpy.registry import converts_from_numpy, converts_to_numpy
from teleopctl.interfaces import get_message

if TYPE_CHECKING:
    from sensor_msgs.msg import Image

_IMAGE = get_message("sensor_msgs/msg/Image")


# Any, here and below: numbers of the kind that the encoding names.
@converts_to_numpy(_IMAGE)
def image_to_numpy(msg: "Image") -> npt.NDArray[Any]:
    """Return the pixels of an image.

    Raises:
        TypeError: The encoding is not known, or the bytes are not of that size.
    """
    return CvBridge().imgmsg_to_cv2(msg)


@converts_from_numpy(_IMAGE)
def numpy_to_image(arr: npt.NDArray[Any], encoding: str) -> "Image":
    """Return pixels as an image.

    Raises:
        TypeError: The encoding is not known, or the array has other numbers or channels than it.
    """
    if arr.ndim not in (2, 3):
        raise TypeError("Array must be two or three dimensional")
    message: Image = CvBridge().cv2_to_imgmsg(np.ascontiguousarray(arr), encoding)
    return message
