"""RViz's colour transformers: colours of points by channel, axis or one for all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.tf import Transform, matrix_from_quaternion
from teleopctl.viewer.displays.properties import Color, Properties, Property
from teleopctl.viewer.displays.sensors.cloud import Cloud

INTENSITY, RGB8, RGBF32, AXIS, FLAT = "Intensity", "RGB8", "RGBF32", "AxisColor", "FlatColor"

COLOR_PROPERTIES = (
    Property("Color Transformer", INTENSITY, choices=(INTENSITY, RGB8, RGBF32, AXIS, FLAT)),
    Property("Color", (255, 255, 255), hint="Of FlatColor"),
    Property("Channel Name", "intensity", hint="Of Intensity: the field that is shown"),
    Property("Use rainbow", True, hint="Intensity: use rainbow colours"),
    Property("Invert Rainbow", False),
    Property("Min Color", (0, 0, 0), hint="Of Intensity without rainbow"),
    Property("Max Color", (255, 255, 255), hint="Of Intensity without rainbow"),
    Property("Autocompute Intensity Bounds", True),
    Property("Min Intensity", 0.0),
    Property("Max Intensity", 4096.0),
    Property("Axis", "Z", choices=("X", "Y", "Z"), hint="Of AxisColor"),
    Property("Autocompute Value Bounds", True, hint="Of AxisColor"),
    Property("Autocompute Value Bounds/Min Value", -10.0),
    Property("Autocompute Value Bounds/Max Value", 10.0),
    Property("Use Fixed Frame", True, hint="Of AxisColor: not the sensor's own axis"),
)

Colors = npt.NDArray[np.uint8]
_STEPS = 256


def _rainbow() -> Colors:
    """Return RViz's rainbow: red, yellow, green, blue, magenta, (256, 3)."""
    hue = 5.0 * np.linspace(1.0, 0.0, _STEPS)
    # the colours of hues from 0 to 5/6 of the circle, from red to magenta
    place = (5.0 - hue)[:, None]
    sixths = np.abs((place + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0
    colors: Colors = (255.0 * sixths.clip(0.0, 1.0)).round().astype(np.uint8)
    return colors


_RAINBOW = _rainbow()


@dataclass(frozen=True, slots=True)
class Coloring:
    """Copy of a point display's colour properties, for use in another thread.

    Attributes:
        transformer: RViz's name of the selected transformer; empty if the file has none.
        color: Colour of all points, for ``FlatColor``.
        channel: Name of the channel for ``Intensity``.
        axis: Index of the axis for ``AxisColor``.
        in_fixed_frame: Whether the axis is one of the fixed frame, instead of the sensor's.
        intensity_bounds: Smallest and largest intensity of the colour scale; None for those of
            the message.
        value_bounds: Smallest and largest coordinate for ``AxisColor``; None for those of the
            message.
        table: Colour scale from smallest to largest value, (256, 3).
    """

    transformer: str
    color: Color
    channel: str
    axis: int
    in_fixed_frame: bool
    intensity_bounds: tuple[float, float] | None
    value_bounds: tuple[float, float] | None
    table: Colors

    @classmethod
    def from_properties(cls, properties: Properties) -> Coloring:
        """Return a copy of a display's colour properties, with its colour scale as a table."""
        if properties.flag("Use rainbow"):
            table = _RAINBOW[::-1] if properties.flag("Invert Rainbow") else _RAINBOW
        else:
            low, high = (
                np.array(properties.color(name), float) for name in ("Min Color", "Max Color")
            )
            table = (low + np.linspace(0.0, 1.0, _STEPS)[:, None] * (high - low)).astype(np.uint8)
        along = "Autocompute Value Bounds"
        return cls(
            properties.text("Color Transformer") if "Color Transformer" in properties.given else "",
            properties.color("Color"),
            properties.text("Channel Name"),
            "XYZ".index(properties.text("Axis")),
            properties.flag("Use Fixed Frame"),
            None
            if properties.flag("Autocompute Intensity Bounds")
            else (properties.number("Min Intensity"), properties.number("Max Intensity")),
            None
            if properties.flag(along)
            else (properties.number(f"{along}/Min Value"), properties.number(f"{along}/Max Value")),
            table,
        )

    def colors(self, cloud: Cloud, pose: Transform) -> tuple[Colors, str]:
        """Return the colours of points, and the name of the colour transformer that was used.

        Args:
            cloud: Points to colour.
            pose: Pose of the points' frame in the fixed frame.

        Returns:
            Colours, (n, 3), or one for all, (3,); and the transformer, not the selected one if the
            points lack its channels.
        """
        wishes = (self.transformer or RGB8, RGB8, RGBF32, INTENSITY, AXIS)
        for transformer in wishes:
            found = self._by(transformer, cloud, pose)
            if found is not None:
                return found, transformer
        raise AssertionError("points have no intensity or colour")

    def _by(self, transformer: str, cloud: Cloud, pose: Transform) -> Colors | None:
        channels = cloud.channels
        if transformer == FLAT:
            return np.array(self.color, np.uint8)
        if transformer == RGB8:
            packed = channels.get("rgb", channels.get("rgba"))
            return None if packed is None or packed.itemsize != 4 else _unpacked(packed)
        if transformer == RGBF32:
            if not {"r", "g", "b"} <= channels.keys():
                return None
            parts = np.stack([channels[name] for name in "rgb"], -1).astype(np.float64)
            return (255.0 * np.nan_to_num(parts).clip(0.0, 1.0)).astype(np.uint8)
        if transformer == INTENSITY:
            values = channels.get(self.channel)
            return None if values is None else self._scaled(values, self.intensity_bounds)
        points = cloud.points
        if not self.in_fixed_frame:
            return self._scaled(points[:, self.axis], self.value_bounds)
        turn = np.array(matrix_from_quaternion(pose.rotation)[self.axis], np.float32)
        return self._scaled(points @ turn + pose.translation[self.axis], self.value_bounds)

    # Any: numbers of any type.
    def _scaled(self, values: npt.NDArray[Any], bounds: tuple[float, float] | None) -> Colors:
        numbers = values.astype(np.float64)
        finite = np.isfinite(numbers)
        if bounds is None:
            known = numbers if finite.all() else numbers[finite]
            bounds = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        low, high = bounds
        span = high - low
        if not 0.0 < span < np.inf:
            span = 1.0
        with np.errstate(over="ignore", invalid="ignore"):
            place = np.where(finite, (numbers - low) / span, 0.0).clip(0.0, 1.0)
        colors: Colors = self.table[(place * (_STEPS - 1)).astype(np.intp)]
        return colors


# Any: numbers of four bytes, of any type.
def _unpacked(packed: npt.NDArray[Any]) -> Colors:
    """Return RGB bytes of 0xAARRGGBB, which drivers often declare as float32."""
    order = packed.dtype.newbyteorder("=")
    bits = np.ascontiguousarray(packed.astype(order)).view(np.uint32)
    return np.stack([bits >> 16, bits >> 8, bits], -1).astype(np.uint8)
