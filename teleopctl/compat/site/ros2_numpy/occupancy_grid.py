"""``ros2_numpy.occupancy_grid``. Maps as masked arrays: unknown cells (-1) are masked."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ros2_numpy.registry import converts_from_numpy, converts_to_numpy
from teleopctl.interfaces import get_message

if TYPE_CHECKING:
    from nav_msgs.msg import MapMetaData, OccupancyGrid

_GRID = get_message("nav_msgs/msg/OccupancyGrid")


# Any: the shape and the kind of numbers are left open.
@converts_to_numpy(_GRID)
def occupancygrid_to_numpy(msg: "OccupancyGrid") -> "np.ma.MaskedArray[Any, Any]":
    """Return the cells of a map, (height, width), from 0 (free) to 100 (occupied)."""
    cells = np.array(msg.data, dtype=np.int8).reshape(msg.info.height, msg.info.width)
    return np.ma.MaskedArray(cells, mask=cells == -1, fill_value=-1)


@converts_from_numpy(_GRID)
def numpy_to_occupancy_grid(
    arr: npt.NDArray[np.int8], info: "MapMetaData | None" = None
) -> "OccupancyGrid":
    """Return cells as a map; masked cells are unknown.

    Args:
        arr: The cells, (height, width).
        info: Where they lie; their number is written into it.

    Raises:
        TypeError: They are not of two dimensions, or no int8.
    """
    if arr.ndim != 2:
        raise TypeError("Array must be 2D")
    if arr.dtype != np.int8:
        raise TypeError("Array must be of int8s")
    cells = arr.filled(-1) if isinstance(arr, np.ma.MaskedArray) else arr
    grid: OccupancyGrid = _GRID(data=cells.ravel().tolist())
    if info is not None:
        grid.info = info
    grid.info.height, grid.info.width = cells.shape
    return grid
