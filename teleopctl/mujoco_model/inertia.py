"""Repairs of masses and inertias that a physics engine cannot step.

Robot descriptions from CAD exports and tutorials come with links of no mass, with zero inertias
and with inertias that no body can have. Each repair is told by one warning that names the link.
"""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import mujoco

# Where only shapes are known, links are as dense as water, in kg/m^3.
DENSITY = 1000.0

# A frame that moves but has neither mass nor shape: light enough to be felt by nothing.
_DUMMY_MASS_KG = 1e-3
_DUMMY_RADIUS_M = 0.03

# Below this MuJoCo takes a mass or an inertia for zero.
_SMALLEST = 1e-15

# A part of the largest moment of inertia that rounding may make of nothing.
_ROUNDING = 1e-9


def repair_inertias(spec: mujoco.MjSpec, but: Container[str] = ()) -> list[str]:
    """Give every moving link a mass and an inertia that physics can work with.

    Args:
        spec: The ``mujoco.MjSpec`` to repair, meshes already resolved.
        but: The links whose mass is meant to be that of their shapes.

    Returns:
        One warning per repaired link.
    """
    warnings: list[str] = []
    for body in spec.bodies:
        if body.name == "world" or body.name in but:
            continue
        warning = _repair(body)
        if warning is not None:
            warnings.append(warning)
    return warnings


def _repair(body: Any) -> str | None:
    moving = len(body.joints) > 0
    if not body.explicitinertial or not body.mass >= _SMALLEST:
        if not moving or _carries_mass(body):
            _make_massless(body)
            return None
        return _invent(body, "has no mass")
    principal = np.linalg.eigvalsh(_inertia(body))
    if principal[0] < _SMALLEST:
        return _invent_inertia(body, principal)
    excess = principal[2] - principal[0] - principal[1]
    if excess > -_ROUNDING * principal[2]:
        _lower_largest_moment(body)
    if excess > _ROUNDING * principal[2]:
        return (
            f"Link '{body.name}': no body has the principal moments of inertia "
            f"{_numbers(principal)}: the largest exceeds the sum of the others by {excess:.4g} and "
            "is lowered to it"
        )
    return None


def _carries_mass(body: Any) -> bool:
    """Whether links fixed to this one bring the mass that it lacks itself."""
    # Not by recursion: a chain of links may be longer than Python's stack.
    waiting = list(body.bodies)
    while waiting:
        child = waiting.pop()
        if len(child.joints) > 0:
            continue
        if child.explicitinertial and child.mass > _SMALLEST:
            return True
        waiting += child.bodies
    return False


def _make_massless(body: Any) -> None:
    """Keep a link without inertia from getting one computed from its shape."""
    for geom in body.geoms:
        geom.density = 0.0
    body.explicitinertial = False


def _invent(body: Any, what: str) -> str:
    solid = [geom for geom in body.geoms if geom.contype] or list(body.geoms)
    body.explicitinertial = False
    # MuJoCo takes the shapes' only where no place of the centre of mass is known.
    body.ipos = [np.nan, 0.0, 0.0]
    body.fullinertia = [np.nan, 0.0, 0.0, 0.0, 0.0, 0.0]
    for geom in body.geoms:
        geom.density = 0.0
    for geom in solid:
        geom.density = DENSITY
    if solid:
        return (
            f"Link '{body.name}' {what}; it is computed from its shape with a density of "
            f"{DENSITY:g} kg/m^3"
        )
    _set_ball(body, _DUMMY_MASS_KG)
    return f"Link '{body.name}' {what} and no shape; {_DUMMY_MASS_KG:g} kg is assumed"


def _invent_inertia(body: Any, principal: np.ndarray) -> str:
    _set_ball(body, float(body.mass))
    return (
        f"Link '{body.name}' has the principal moments of inertia {_numbers(principal)}, which "
        f"must be positive; those of a ball of {body.mass:g} kg and {_DUMMY_RADIUS_M:g} m radius "
        "are used"
    )


def _set_ball(body: Any, mass: float) -> None:
    moment = 0.4 * mass * _DUMMY_RADIUS_M**2
    body.explicitinertial = True
    body.mass = mass
    if not np.isfinite(body.ipos[0]):
        body.ipos = [0.0, 0.0, 0.0]
    body.fullinertia = [moment, moment, moment, 0.0, 0.0, 0.0]


def _inertia(body: Any) -> np.ndarray:
    """The inertia about the centre of mass, (3, 3), in kg m^2."""
    xx, yy, zz, xy, xz, yz = (float(value) for value in body.fullinertia)
    if not np.isfinite(xx):
        # MuJoCo keeps an inertia of zeros as an unset one.
        return np.diag(np.asarray(body.inertia, dtype=float))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _lower_largest_moment(body: Any) -> None:
    """Make the largest principal moment the sum of the others, and rounding less."""
    moments, axes = np.linalg.eigh(_inertia(body))
    moments[2] = (moments[0] + moments[1]) * (1.0 - _ROUNDING)
    lowered = axes @ np.diag(moments) @ axes.T
    body.fullinertia = [*np.diag(lowered), lowered[0, 1], lowered[0, 2], lowered[1, 2]]


def _numbers(values: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
