"""The colours that Gazebo has by name."""

from __future__ import annotations

_GAZEBO_COLOURS = {
    "black": (0.05, 0.05, 0.05),
    "blue": (0.1, 0.2, 0.85),
    "darkgray": (0.25, 0.25, 0.25),
    "darkgrey": (0.25, 0.25, 0.25),
    "gray": (0.6, 0.6, 0.6),
    "green": (0.1, 0.7, 0.15),
    "grey": (0.6, 0.6, 0.6),
    "indigo": (0.33, 0.0, 0.5),
    "orange": (0.95, 0.45, 0.05),
    "purple": (0.6, 0.1, 0.7),
    "red": (0.85, 0.1, 0.1),
    "turquoise": (0.1, 0.8, 0.75),
    "white": (0.95, 0.95, 0.95),
    "yellow": (0.95, 0.85, 0.1),
}


def gazebo_colour(material: str) -> tuple[float, float, float] | None:
    """Return the colour (0 to 1) of a Gazebo material such as ``Gazebo/Orange``."""
    return _GAZEBO_COLOURS.get(material.rpartition("/")[2].lower())
