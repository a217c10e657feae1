"""Contact properties of a shape beyond sliding friction: ``<surface>`` of SDF."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from lxml import etree

from teleopctl.robot.urdf_text import numbers

_TORSIONAL = "friction/torsional/coefficient"
_PATCH = "friction/torsional/patch_radius"
_ROLLING = "friction/bullet/rolling_friction"
_OF_ODE = "friction/ode/mu"
_RESTITUTION = "bounce/restitution_coefficient"


@dataclass(frozen=True, slots=True)
class Surface:
    """Contact properties of a shape: restitution, torsional and rolling friction.

    Attributes:
        restitution: Coefficient of restitution, 0 to 1; that of a contact is the product of both
            shapes' coefficients.
        torsional: Coefficient of torsional friction.
        patch_radius: Radius of the contact patch, for torsional friction, in metres.
        rolling: Rolling friction in metres: moment divided by the contact force and by the
            friction coefficient of the other shape.
    """

    restitution: float = 0.0
    torsional: float = 1.0
    patch_radius: float = 0.0
    rolling: float = 0.0

    @property
    def values(self) -> list[float]:
        """Contact properties as numbers, in the order of the attributes."""
        return list(asdict(self).values())


@dataclass(frozen=True, slots=True)
class Across:
    """Direction-dependent friction of a shape: direction, and the coefficient across.

    Attributes:
        coefficient: Coefficient of friction across the direction; along the direction the shape's
            usual coefficient applies.
        along: Direction in the frame of ``link``: x, y, z.
        link: Name of the link; empty for the shape's own.
    """

    coefficient: float
    along: tuple[float, float, float]
    link: str = ""


# Any, here and below: lxml elements, whose class has no types.
def expressed_in(element: Any) -> str:
    """Return the frame of an SDF ``<fdir1>`` by its ``expressed_in``; empty without one."""
    for name, value in element.attrib.items():
        if name.rpartition("}")[2].rpartition(":")[2] == "expressed_in":
            return str(value)
    return ""


def read_surface(number: Callable[[str, float], float]) -> Surface | None:
    """Return the `Surface` that the function `number` reads; None if all values are defaults.

    Args:
        number: Function called with a path below ``<surface>`` and a default; returns the number at
            the path, or the default.
    """
    # Gazebo uses Bullet's rolling friction with the Bullet engine only. In files that also have
    # ODE's friction, which all engines use, wheels with it roll freely in the other engines.
    rolls_freely = number(_OF_ODE, -1.0) >= 0.0
    found = Surface(
        min(max(number(_RESTITUTION, 0.0), 0.0), 1.0),
        max(number(_TORSIONAL, 1.0), 0.0),
        max(number(_PATCH, 0.0), 0.0),
        0.0 if rolls_freely else max(number(_ROLLING, 0.0), 0.0),
    )
    return None if found == Surface() else found


def add_surface(holder: Any, surface: Surface) -> None:
    """Write a ``<surface>`` element for a shape's contact properties into an element."""
    for path, value in (
        (_RESTITUTION, surface.restitution),
        (_TORSIONAL, surface.torsional),
        (_PATCH, surface.patch_radius),
        (_ROLLING, surface.rolling),
    ):
        element = holder
        for tag in ("surface", *path.split("/")):
            child = element.find(tag)
            element = etree.SubElement(element, tag) if child is None else child
        element.text = numbers(value)
