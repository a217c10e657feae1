"""A plot as a file: its samples as CSV, its lines as a PNG picture."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from teleopctl.printable import printable_line
from teleopctl.viewer.panels.plots.series import Floats

# Drawn larger and made smaller: Pillow's lines have no soft edges by themselves.
_LARGER = 2
_SIZE = (1600, 900)
_LEFT, _TOP, _RIGHT, _LINE_HEIGHT = 110, 30, 30, 34
_FONT_SIZE = 22
_INK, _GRID, _PAPER = "#202428", "#dde1e6", "#ffffff"
_TICKS = 8
# Above and below the curves, of their height.
_ROOM = 0.05


def to_csv(names: Sequence[str], samples: Sequence[tuple[Floats, Floats]]) -> bytes:
    """Write samples: a row for each time, a column for each name; empty where there is none.

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


class Curve(NamedTuple):
    """A line of a picture: its name, its colour, its values at the picture's times."""

    name: str
    color: str
    values: Floats


def to_png(times: Floats, curves: Sequence[Curve]) -> bytes:
    """Draw curves over the same times, with axes and a legend.

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
    x_low, x_high = _range(times)
    y_low, y_high = _range(np.concatenate([np.empty(0), *(curve.values for curve in curves)]))
    room = (y_high - y_low) * _ROOM
    y_low, y_high = y_low - room, y_high + room

    def x_of(value: float) -> float:
        return left + (value - x_low) / (x_high - x_low) * (right - left)

    def y_of(value: float) -> float:
        return bottom - (value - y_low) / (y_high - y_low) * (bottom - top)

    for tick in _ticks(x_low, x_high):
        draw.line([(x_of(tick), top), (x_of(tick), bottom)], _GRID, _LARGER)
        draw.text((x_of(tick), bottom + line_height / 2), f"{tick:g} s", _INK, font, "mm")
    for tick in _ticks(y_low, y_high):
        draw.line([(left, y_of(tick)), (right, y_of(tick))], _GRID, _LARGER)
        draw.text((left - 8 * _LARGER, y_of(tick)), f"{tick:g}", _INK, font, "rm")
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


def _range(values: Floats) -> tuple[float, float]:
    """The least and the greatest value that a float can tell apart, with room around one."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if not math.isfinite(high - low):
        low, high = low / 4, high / 4
    if high - low <= 1e-12 * max(abs(low), abs(high), 1e-12):
        room = max(abs(low) * 1e-3, 1e-9)
        return low - room, high + room
    return low, high


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers between two others: 1, 2 or 5 of a power of ten apart."""
    rough = (high - low) / _TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = power * next(factor for factor in (1, 2, 5, 10) if factor * power >= rough)
    first = math.ceil(low / step)
    return [
        round(number * step, 12)
        for number in range(first, first + 2 * _TICKS)
        if number * step <= high
    ]
