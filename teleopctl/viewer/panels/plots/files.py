"""A plot as a file: its samples as CSV, its lines as a PNG picture."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from teleopctl.base.printable import printable_line
from teleopctl.viewer.panels.plots.series import Floats
from teleopctl.viewer.panels.plots.vertical_axis import VerticalAxis, vertical_axis

# Drawn larger and made smaller: Pillow's lines have no soft edges by themselves.
_LARGER = 2
_SIZE = (1600, 900)
_LEFT, _TOP, _RIGHT, _LINE_HEIGHT = 110, 30, 30, 34
_FONT_SIZE = 22
_INK, _GRID, _PAPER = "#202428", "#dde1e6", "#ffffff"
_MOST_STEPS = 8


def to_csv(names: Sequence[str], samples: Sequence[tuple[Floats, Floats]]) -> bytes:
    """Return samples as CSV: a row per time and a column per name.

    Args:
        names: Titles of the columns.
        samples: Times and values for each name.
    """
    rows: dict[float, list[str]] = {}
    for column, (times, values) in enumerate(samples):
        for time_s, value in zip(times.tolist(), values.tolist(), strict=True):
            rows.setdefault(time_s, [""] * len(names))[column] = repr(value)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["time", *map(printable_line, names)])
    for time_s in sorted(rows):
        writer.writerow([f"{time_s:.9f}", *rows[time_s]])
    return text.getvalue().encode()


class PlotCurve(NamedTuple):
    """A curve of a PNG plot: name, colour and values."""

    name: str
    color: str
    values: Floats


def to_png(times: Floats, curves: Sequence[PlotCurve]) -> bytes:
    """Return a PNG plot of curves over the same times, with axes and a legend.

    Args:
        times: In seconds.
        curves: What to draw; NaN is drawn over.
    """
    from PIL import Image, ImageDraw, ImageFont

    width, height = (_LARGER * side for side in _SIZE)
    image = Image.new("RGB", (width, height), _PAPER)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(_LARGER * _FONT_SIZE)
    left, top, right = _LARGER * _LEFT, _LARGER * _TOP, width - _LARGER * _RIGHT
    line_height = _LARGER * _LINE_HEIGHT
    bottom = height - line_height * (2 + len(curves))
    across = _axis(times)
    upwards = _axis(np.concatenate([np.empty(0), *(curve.values for curve in curves)]))

    def x_of(value: float) -> float:
        return left + (value - across.low) / (across.high - across.low) * (right - left)

    def y_of(value: float) -> float:
        return bottom - (value - upwards.low) / (upwards.high - upwards.low) * (bottom - top)

    for tick, label in zip(across.ticks, across.labels, strict=True):
        draw.line([(x_of(tick), top), (x_of(tick), bottom)], _GRID, _LARGER)
        draw.text((x_of(tick), bottom + line_height / 2), f"{label} s", _INK, font, "mm")
    for tick, label in zip(upwards.ticks, upwards.labels, strict=True):
        draw.line([(left, y_of(tick)), (right, y_of(tick))], _GRID, _LARGER)
        draw.text((left - 8 * _LARGER, y_of(tick)), label, _INK, font, "rm")
    draw.text((left, top - 4 * _LARGER), upwards.title, _INK, font, "lb")
    draw.rectangle([left, top, right, bottom], outline=_INK, width=_LARGER)
    for number, curve in enumerate(curves):
        there = np.isfinite(curve.values)
        points = [
            (x_of(time_s), y_of(value))
            for time_s, value in zip(
                times[there].tolist(), curve.values[there].tolist(), strict=True
            )
        ]
        if len(points) > 1:
            draw.line(points, curve.color, 3 * _LARGER, joint="curve")
        y = bottom + line_height * (1.6 + number)
        draw.line([(left, y), (left + 2 * line_height, y)], curve.color, 4 * _LARGER)
        draw.text((left + 2.5 * line_height, y), printable_line(curve.name), _INK, font, "lm")
    file = io.BytesIO()
    image.resize(_SIZE, Image.Resampling.LANCZOS).save(file, "PNG", optimize=True)
    return file.getvalue()


def _axis(values: Floats) -> VerticalAxis:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    return vertical_axis(low, high, _MOST_STEPS)
