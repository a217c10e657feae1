"""``ParticleCloud``: the guesses of a localization, the likely ones longer."""

from __future__ import annotations

from typing import Any, ClassVar

from teleopctl.tf import Transform
from teleopctl.viewer.displays.base import WARN
from teleopctl.viewer.displays.drawn import DrawnDisplay
from teleopctl.viewer.displays.geometry.pose_array import flat_arrow
from teleopctl.viewer.displays.properties import Property
from teleopctl.viewer.displays.reading import left_out_text, poses_of, rgba_of
from teleopctl.viewer.scene.drawing import ArrowSize, Drawing, is_drawable, merged

# Any stands for messages throughout: their classes are made at run time, from definitions.

# So many lengths are told apart.
_LENGTHS = 20


class ParticleCloud(DrawnDisplay):
    """Display of navigation2's particle clouds, as RViz's plug-in draws them."""

    rviz_class = "ParticleCloud"
    message_type = "nav2_msgs/msg/ParticleCloud"
    properties: ClassVar[tuple[Property, ...]] = (
        Property("Shape", "Arrow (Flat)", choices=("Arrow (Flat)", "Arrow (3D)", "Axes")),
        Property("Color", (0, 180, 0)),
        Property("Alpha", 1.0, low=0.0, high=1.0),
        Property("Min Arrow Length", 0.02, low=0.0, high=1000.0, hint="Of the weight 0"),
        Property("Max Arrow Length", 0.3, low=0.0, high=1000.0, hint="Of the weight 1"),
    )

    def _prepare(self) -> None:
        super()._prepare()
        self.values.given.setdefault("Class", f"nav2_rviz_plugins/{self.rviz_class}")

    def drawing(self, message: Any) -> Drawing:
        """Return a drawing with a shape at each particle, grouped by weight."""
        low = self.values.number("Min Arrow Length")
        more = max(self.values.number("Max Arrow Length") - low, 0.0)
        by_share: dict[float, list[Any]] = {}
        left_out = 0
        for particle in message.particles:
            if not is_drawable((particle.weight,)):
                left_out += 1
                continue
            share = round(_LENGTHS * min(max(particle.weight, 0.0), 1.0)) / _LENGTHS
            by_share.setdefault(share, []).append(particle.pose)
        drawings = []
        for share, poses in by_share.items():
            positions, rotations, wrong = poses_of(poses)
            left_out += wrong
            drawings.append(self._shape(low + share * more).copies(positions, rotations))
        if left_out:
            self.say(WARN, left_out_text(left_out, "particles"))
        return merged(drawings)

    def _shape(self, length: float) -> Drawing:
        values, drawing = self.values, Drawing()
        alpha = values.number("Alpha")
        color = rgba_of(values.color("Color"), alpha)
        shape = values.text("Shape")
        # RViz's proportions, which are those of the arrows of PoseArray: 0.23, 0.01, 0.07, 0.03.
        if shape == "Axes":
            drawing.axes(Transform(), length, length / 23, alpha)
        elif shape == "Arrow (3D)":
            head, width = length * 7 / 23, length * 2 / 23
            drawing.arrow(Transform(), ArrowSize(length, width, head, 3 * width), color)
        elif alpha > 0.0:
            flat_arrow(drawing, length, color)
        return drawing
