"""Repairs of masses and inertias that a physics engine cannot step.

Robot descriptions from CAD exports and tutorials contain links without mass, with zero inertias
and with inertias that no body can have. Each repair is reported by one warning with the link's
name.
"""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import mujoco

# Density of links of which only shapes are known, that of water, in kg/m^3.
DENSITY = 1000.0

# Moving links with neither mass nor shape get this mass: too light to affect other links.
_DUMMY_MASS_KG = 1e-3
_DUMMY_RADIUS_M = 0.03

# MuJoCo treats masses and inertias below this value as zero.
_SMALLEST = 1e-15

# No link of a robot has a larger radius of gyration, that of an object 100 m long: the inertia is
# in other units, mostly g mm^2.
_LARGEST_RADIUS_M = 30.0

# MuJoCo treats principal moments of inertia below this value (kg m^2) as zero.
_SMALLEST_MOMENT = 1e-14
# A rod's moment about its own axis is lost in the digits of the others: it is set to this fraction
# of the largest one, as for a rod a hundred times as long as wide. A moment below zero by no more
# than that counts as a rod's as well.
_OF_A_ROD = 1e-5

# Rounding error of a moment of inertia, as a fraction of the largest moment.
_ROUNDING = 1e-9


def repair_inertias(spec: mujoco.MjSpec, exempt_links: Container[str] = ()) -> list[str]:
    """Repair masses and inertias of all links not exempt; return a warning per repaired link.

    Args:
        spec: The ``mujoco.MjSpec`` to repair, meshes already resolved.
        exempt_links: Links whose mass MuJoCo computes from their shapes.
    """
    warnings: list[str] = []
    for body in spec.bodies:
        if body.name == "world" or body.name in exempt_links:
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
        return _estimate_mass(body, "has no mass")
    principal = np.linalg.eigvalsh(_inertia(body))
    if abs(principal[0]) <= _OF_A_ROD * principal[2] and principal[1] >= _SMALLEST_MOMENT:
        if principal[0] < _SMALLEST_MOMENT:
            return _raise_smallest_moment(body)
    elif principal[0] < _SMALLEST_MOMENT:
        return _invent_inertia(body, principal, "must be positive")
    radius = float(np.sqrt(principal[2] / body.mass))
    if radius > _LARGEST_RADIUS_M:
        what = (
            f"are those of {body.mass:g} kg {radius:.0f} m from its centre; the units may be wrong"
        )
        return _invent_inertia(body, principal, what)
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
    """Whether links that are fixed to a massless link have mass."""
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


def _estimate_mass(body: Any, what: str) -> str:
    solid = [geom for geom in body.geoms if geom.contype] or list(body.geoms)
    body.explicitinertial = False
    # MuJoCo computes masses from shapes only where the centre of mass is unset.
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


def _invent_inertia(body: Any, principal: np.ndarray, what: str) -> str:
    _set_ball(body, float(body.mass))
    return (
        f"Link '{body.name}' has the principal moments of inertia {_numbers(principal)}, which "
        f"{what}; those of a ball of {body.mass:g} kg and {_DUMMY_RADIUS_M:g} m radius are used"
    )


def _set_ball(body: Any, mass: float) -> None:
    moment = 0.4 * mass * _DUMMY_RADIUS_M**2
    body.explicitinertial = True
    body.mass = mass
    if not np.isfinite(body.ipos[0]):
        body.ipos = [0.0, 0.0, 0.0]
    body.fullinertia = [moment, moment, moment, 0.0, 0.0, 0.0]


def _inertia(body: Any) -> np.ndarray:
    """Return the inertia about the centre of mass, (3, 3), in kg m^2."""
    xx, yy, zz, xy, xz, yz = (float(value) for value in body.fullinertia)
    if not np.isfinite(xx):
        # MuJoCo stores an inertia of zeros as unset.
        return np.diag(np.asarray(body.inertia, dtype=float))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _raise_smallest_moment(body: Any) -> str:
    moments, axes = np.linalg.eigh(_inertia(body))
    before = _numbers(moments)
    moments[0] = _OF_A_ROD * moments[2]
    moments[2] = min(moments[2], (moments[0] + moments[1]) * (1.0 - _ROUNDING))
    _set_inertia(body, moments, axes)
    return (
        f"Link '{body.name}' has the principal moments of inertia {before}, of which the smallest "
        f"is raised to {moments[0]:.4g}"
    )


def _set_inertia(body: Any, moments: np.ndarray, axes: np.ndarray) -> None:
    full = axes @ np.diag(moments) @ axes.T
    body.fullinertia = [*np.diag(full), full[0, 1], full[0, 2], full[1, 2]]


def _lower_largest_moment(body: Any) -> None:
    """Lower the largest principal moment to the sum of the others, less rounding."""
    moments, axes = np.linalg.eigh(_inertia(body))
    moments[2] = (moments[0] + moments[1]) * (1.0 - _ROUNDING)
    _set_inertia(body, moments, axes)


def _numbers(values: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
