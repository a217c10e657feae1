"""A pose as an arrow along its x axis, or as its axes."""

from __future__ import annotations

from teleopctl.tf import Transform
from teleopctl.viewer.displays.properties import Properties, Property
from teleopctl.viewer.displays.reading import rgba_of
from teleopctl.viewer.scene.drawing import ArrowSize, Drawing

_MOST_M = 1000.0


def shape_properties(group: str = "") -> tuple[Property, ...]:
    """Return the properties of a pose's shape, below a group.

    Args:
        group: What they stand below in a file; empty where they are the display's own.
    """
    above = f"{group}/" if group else ""
    return (
        Property(group or "Shape", "Arrow", choices=("Arrow", "Axes")),
        Property(f"{above}Color", (255, 25, 0)),
        Property(f"{above}Alpha", 1.0, low=0.0, high=1.0),
        Property(f"{above}Shaft Length", 1.0, low=0.0, high=_MOST_M),
        Property(f"{above}Shaft Radius", 0.05, low=0.0, high=_MOST_M),
        Property(f"{above}Head Length", 0.3, low=0.0, high=_MOST_M),
        Property(f"{above}Head Radius", 0.1, low=0.0, high=_MOST_M),
        Property(f"{above}Axes Length", 1.0, low=0.0, high=_MOST_M),
        Property(f"{above}Axes Radius", 0.1, low=0.0, high=_MOST_M),
    )


def draw_pose(drawing: Drawing, pose: Transform, values: Properties, group: str = "") -> None:
    """Add the shape of a pose (axes or arrow) to a drawing, according to the properties."""
    above = f"{group}/" if group else ""
    alpha = values.number(f"{above}Alpha")
    if values.text(group or "Shape") == "Axes":
        length = values.number(f"{above}Axes Length")
        drawing.axes(pose, length, values.number(f"{above}Axes Radius"), alpha)
        return
    size = ArrowSize(
        values.number(f"{above}Shaft Length"),
        2 * values.number(f"{above}Shaft Radius"),
        values.number(f"{above}Head Length"),
        2 * values.number(f"{above}Head Radius"),
    )
    drawing.arrow(pose, size, rgba_of(values.color(f"{above}Color"), alpha))
