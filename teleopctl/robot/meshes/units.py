"""The unit of length of a mesh file, for all who read meshes: picture and physics.

Of the formats that robots use only COLLADA says one. trimesh hands it on and does not apply it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

# Beyond these a header is a mistake.
_SMALLEST_M, _LARGEST_M = 1e-6, 1e6


def collada_unit_m(metadata: Iterable[Mapping[str, object]]) -> float:
    """How many metres the unit of a COLLADA file has; 1 where its header makes no sense.

    Args:
        metadata: What trimesh says of the file's meshes, such as ``{"units": "0.001 * meter"}``.
    """
    words = next((str(one.get("units", "")) for one in metadata), "").split()
    try:
        unit = float(words[0]) if len(words) == 3 else 1.0
    except ValueError:
        return 1.0
    return unit if _SMALLEST_M < unit < _LARGEST_M else 1.0
