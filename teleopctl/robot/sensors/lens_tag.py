"""``<lens>`` of a wide angle camera: how far from the middle each direction is seen."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from teleopctl.errors import InvalidDescriptionError
from teleopctl.robot.elements import XmlElement, child_text, describe, to_number

WIDE_ANGLE_TYPES = frozenset(("wideanglecamera", "wide_angle_camera"))

# SDF's functions, and how they rise.
_FUNCTIONS: dict[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "tan": (math.tan, lambda angle: 1.0 + math.tan(angle) ** 2),
    "sin": (math.sin, math.cos),
    "id": (float, lambda _: 1.0),
}
# c1, c2 and the function of the projections that have names.
_TYPES = {
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}
# That of a pinhole.
_STRAIGHT = ("gnomonical", "gnomonic")
# SDF's own, in radians from the axis.
_CUTOFF = 1.5707
_TRUE = ("true", "1")


@dataclass(frozen=True, slots=True)
class Lens:
    """A projection r = c1 f fun(theta / c2 + c3) of a direction theta from the axis.

    r is 1 at the left and right edge of the image.

    Attributes:
        c1: See above.
        c2: See above.
        c3: See above.
        f: See above.
        fun: ``tan``, ``sin`` or ``id``.
        cutoff: What is farther from the axis is not seen, in radians.
    """

    c1: float
    c2: float
    c3: float
    f: float
    fun: str
    cutoff: float

    def radius(self, theta: float) -> float:
        """Return the image radius of a direction at an angle from the optical axis."""
        return self.c1 * self.f * _FUNCTIONS[self.fun][0](theta / self.c2 + self.c3)

    @property
    def focal_length(self) -> float:
        """Derivative of the image radius by the angle at the optical axis, per radian."""
        return self.c1 * self.f / self.c2 * _FUNCTIONS[self.fun][1](self.c3)


def read_lens(element: XmlElement | None, horizontal_fov: float, where: XmlElement) -> Lens | None:
    """Read the ``<lens>`` of a wide angle camera.

    Args:
        element: The tag; None for what SDF means then.
        horizontal_fov: What the camera sees between the edges of its image, in radians.
        where: The camera.

    Returns:
        The lens; None where the camera is a pinhole all the same.

    Raises:
        InvalidDescriptionError: There is no such lens, or it cannot see so far.
    """
    kind = "stereographic" if element is None else child_text(element, "type", "stereographic")
    scaled = element is None or child_text(element, "scale_to_hfov", "true").lower() in _TRUE
    if kind in _STRAIGHT and scaled:
        return None
    c3, f = 0.0, 1.0
    own = None if element is None else element.find("custom_function")
    if kind == "custom":
        c1, c2, c3, f = (
            _number(own, tag, usual)
            for tag, usual in (("c1", 1.0), ("c2", 1.0), ("c3", 0.0), ("f", 1.0))
        )
        fun = "tan" if own is None else child_text(own, "fun", "tan")
    elif kind in _TYPES:
        c1, c2, fun = _TYPES[kind]
    else:
        raise InvalidDescriptionError(
            f"{describe(where)}: <lens> is of the type '{kind}': one of custom, "
            f"{', '.join(_TYPES)}; gnomonical where it is scaled"
        )
    if fun not in _FUNCTIONS:
        raise InvalidDescriptionError(
            f"{describe(where)}: <fun> is '{fun}': one of {', '.join(_FUNCTIONS)}"
        )
    if scaled:
        edge = Lens(c1, c2, c3, 1.0, fun, math.pi).radius(horizontal_fov / 2.0)
        f = 1.0 / edge if edge else 0.0
    # Beyond a right angle a sine falls, and a tangent begins anew.
    rises = fun == "id" or 0.0 <= c3 <= horizontal_fov / 2.0 / c2 + c3 < math.pi / 2.0
    if not (rises and c1 * f > 0.0 and c2 > 0.0 and 0.0 < horizontal_fov <= 2.0 * math.pi):
        raise InvalidDescriptionError(
            f"{describe(where)}: such a <lens> does not see {horizontal_fov:g} rad"
        )
    return Lens(c1, c2, c3, f, fun, _number(element, "cutoff_angle", _CUTOFF))


def _number(element: XmlElement | None, tag: str, usual: float) -> float:
    text = "" if element is None else child_text(element, tag)
    value = to_number(text) if text else usual
    if value is None or not math.isfinite(value):
        raise InvalidDescriptionError(f"<{tag}> of <lens> should be a number, got '{text}'")
    return value
