"""How a shape touches beyond its friction along the contact: ``<surface>`` of SDF."""

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
        restitution: Its part of the speed that is thrown back, from 0 to 1; that of two that touch
            is the product of theirs.
        torsional: Its coefficient of friction against spinning on the spot.
        patch_radius: Of the patch that it touches with, which spinning is braked by, in metres.
        rolling: Its resistance to rolling: the moment by the contact's force and by the friction
            of the other shape, in metres.
    """

    restitution: float = 0.0
    torsional: float = 1.0
    patch_radius: float = 0.0
    rolling: float = 0.0

    @property
    def values(self) -> list[float]:
        """Return the contact properties as numbers, in the order of the attributes."""
        return list(asdict(self).values())


@dataclass(frozen=True, slots=True)
class Across:
    """Direction-dependent friction of a shape: direction, and the coefficient across.

    Attributes:
        coefficient: Its coefficient across the direction; along it, it has its usual one.
        along: The direction, in a link's frame: x, y, z.
        link: The link; empty for the shape's own.
    """

    coefficient: float
    along: tuple[float, float, float]
    link: str = ""


# Any, here and below: elements of lxml, whose class has no types.
def expressed_in(element: Any) -> str:
    """Return the frame of an SDF ``<fdir1>`` by its ``expressed_in``; empty without one."""
    for name, value in element.attrib.items():
        if name.rpartition("}")[2].rpartition(":")[2] == "expressed_in":
            return str(value)
    return ""


def read_surface(number: Callable[[str, float], float]) -> Surface | None:
    """Read an SDF ``<surface>`` element; return None if all values are defaults.

    Args:
        number: The number at a path below it, or the default.
    """
    # Gazebo reads Bullet's with Bullet alone. Beside ODE's friction, which all read, it is written
    # for that engine too, and wheels that have it roll in the others.
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
