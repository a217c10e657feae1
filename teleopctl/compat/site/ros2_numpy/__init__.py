"""``ros2_numpy``: messages as numpy arrays and back.

Point clouds are structured arrays, as in the releases for ROS 2 (the package of that name on PyPI
has dictionaries instead).
"""

from ros2_numpy import geometry, image, occupancy_grid, point_cloud2
from ros2_numpy.registry import converts_from_numpy, converts_to_numpy, msgify, numpify

__all__ = [
    "converts_from_numpy",
    "converts_to_numpy",
    "geometry",
    "image",
    "msgify",
    "numpify",
    "occupancy_grid",
    "point_cloud2",
]
