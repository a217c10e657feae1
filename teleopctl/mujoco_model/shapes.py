"""Shapes that no body can have: boxes without a width, spheres of an infinite radius.

Descriptions of real robots have them as placeholders. MuJoCo refuses the whole robot for one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

_GEOM = mujoco.mjtGeom
# What each is called, and how many of MuJoCo's three sizes it has.
_SIZED = {
    _GEOM.mjGEOM_BOX: ("box", 3),
    _GEOM.mjGEOM_SPHERE: ("sphere", 1),
    _GEOM.mjGEOM_CYLINDER: ("cylinder", 2),
    _GEOM.mjGEOM_CAPSULE: ("capsule", 2),
}


def drop_impossible_shapes(spec: mujoco.MjSpec) -> list[str]:
    """Remove shapes with invalid sizes.

    Returns:
        One warning for each link that has some.
    """
    warnings: list[str] = []
    for body in spec.bodies:
        impossible = list(_impossible(body))
        if not impossible:
            continue
        kinds = ", ".join(dict.fromkeys(_SIZED[geom.type][0] for geom in impossible))
        warnings.append(
            f"Shapes of link '{body.name}' ({kinds}) are left out: "
            "their sizes must be positive, finite numbers"
        )
        for geom in impossible:
            spec.delete(geom)
    return warnings


# Any stands for MuJoCo's bodies and geoms, whose classes have no types.
def _impossible(body: Any) -> Iterator[Any]:
    for geom in body.geoms:
        _, count = _SIZED.get(geom.type, ("", 0))
        sizes = np.asarray(geom.size)[:count]
        if not (np.isfinite(sizes).all() and (sizes > 0.0).all()):
            yield geom
