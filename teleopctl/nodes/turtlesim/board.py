"""The board of turtlesim: its size, the lines that pens have drawn, and pictures of turtles."""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

METER = 45.0
"""Pixels of a meter: the height of a turtle's picture in ROS 2's turtlesim."""

PIXELS = 500
"""Width and height of ROS 2's window, in pixels."""

# Picture elements for each of those pixels: a browser shows the board larger than 500 pixels.
_DETAIL = 2
# Points for each pixel of a turtle's picture while it is drawn, which smooths its edges.
_SMOOTH = 8

Pixels = npt.NDArray[np.uint8]


def single(value: float) -> float:
    """Return a number rounded to 32 bits, as C++'s ``float``."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


SIZE = single((PIXELS - 1) / METER)
"""Width and height of the board, m: 11.088889."""


class Colour(NamedTuple):
    """Red, green and blue, from 0 to 255 each."""

    r: int
    g: int
    b: int


class Pen(NamedTuple):
    """Pen of a turtle: its colour, its width in pixels, and whether it draws."""

    colour: Colour = Colour(0xB3, 0xB8, 0xFF)
    width: int = 3
    is_on: bool = True


BACKGROUND = Colour(0x45, 0x56, 0xFF)
"""Default background of the board."""

# Lines to places farther away than this, m, are drawn to here: Pillow's numbers have 32 bits.
_FAR_M = 1000.0

# What a pixel without a line has in ROS 2's picture of lines: white, and transparent.
_EMPTY = (255, 255, 255, 0)


class Board:
    """Picture of the lines that pens have drawn; places are in m, from the upper left corner.

    Attributes:
        drawn: Number of changes so far.
    """

    def __init__(self) -> None:
        self.drawn = 0
        self.clear()

    def clear(self) -> None:
        """Remove all lines."""
        self._lines = Image.new("RGBA", (PIXELS * _DETAIL, PIXELS * _DETAIL), _EMPTY)
        self._draw = ImageDraw.Draw(self._lines)
        self.drawn += 1

    def line(self, begin: tuple[float, float], end: tuple[float, float], pen: Pen) -> None:
        """Draw a line with round ends between two places, unless the pen is off."""
        if not pen.is_on:
            return
        scale = METER * _DETAIL
        places = [
            tuple(min(max(value, -_FAR_M), _FAR_M) * scale for value in place)
            for place in (begin, end)
        ]
        width = max(1, pen.width) * _DETAIL
        self._draw.line(places, fill=pen.colour, width=width)
        for x, y in places:
            half = (width - 1) / 2
            self._draw.ellipse((x - half, y - half, x + half, y + half), fill=pen.colour)
        self.drawn += 1

    def colour_at(self, x: float, y: float) -> Colour:
        """Return the colour of the line at a place; white where there is none."""
        last = PIXELS - 1
        column, row = (min(max(round(value * METER), 0), last) * _DETAIL for value in (x, y))
        pixel = self._lines.getpixel((column, row))
        assert isinstance(pixel, tuple)
        return Colour(*pixel[:3])

    def picture(self, background: Colour) -> Pixels:
        """Return the lines on a background, as an array of height, width and three colours."""
        picture = Image.new("RGB", self._lines.size, background)
        picture.paste(self._lines, mask=self._lines)
        return np.asarray(picture)


class _Look(NamedTuple):
    """Colours of a turtle: its shell with rim and pattern, its skin, and the shell's pattern."""

    shell: Colour
    rim: Colour
    skin: Colour
    pattern: str


_LOOKS = (
    _Look(Colour(72, 140, 72), Colour(38, 88, 46), Colour(150, 196, 92), "hexagons"),
    _Look(Colour(196, 110, 54), Colour(120, 62, 30), Colour(222, 184, 120), "rings"),
    _Look(Colour(60, 126, 168), Colour(28, 72, 106), Colour(140, 206, 204), "hexagons"),
    _Look(Colour(150, 84, 160), Colour(90, 42, 100), Colour(214, 170, 220), "spots"),
    _Look(Colour(204, 70, 70), Colour(124, 32, 36), Colour(238, 196, 140), "hexagons"),
    _Look(Colour(226, 180, 60), Colour(146, 104, 20), Colour(120, 160, 84), "spots"),
    _Look(Colour(54, 92, 90), Colour(24, 48, 50), Colour(136, 176, 160), "rings"),
    _Look(Colour(122, 94, 66), Colour(70, 50, 34), Colour(180, 200, 110), "hexagons"),
)
LOOKS = len(_LOOKS)
"""Number of different pictures of turtles."""


def turtle_picture(look: int) -> Pixels:
    """Return the picture of a turtle that faces up: an array of height, width and four colours.

    Args:
        look: Which of the `LOOKS` pictures.
    """
    shell, rim, skin, pattern = _LOOKS[look]
    side = round(METER) * _SMOOTH
    picture = Image.new("RGBA", (side, side), (*skin, 0))
    draw = ImageDraw.Draw(picture)

    # Places and radii are in parts of the picture's side; y points down.
    def oval(
        x: float, y: float, across: float, along: float, colour: Colour, turned: float = 0.0
    ) -> None:
        outline = []
        for step in range(48):
            angle = 2.0 * math.pi * step / 48
            dx, dy = across * math.cos(angle), along * math.sin(angle)
            cos, sin = math.cos(turned), math.sin(turned)
            outline.append(((x + dx * cos - dy * sin) * side, (y + dx * sin + dy * cos) * side))
        draw.polygon(outline, fill=colour)

    for sign in (-1.0, 1.0):
        oval(0.5 + sign * 0.33, 0.30, 0.085, 0.17, skin, sign * 0.9)
        oval(0.5 + sign * 0.29, 0.79, 0.075, 0.13, skin, -sign * 0.7)
    oval(0.5, 0.93, 0.03, 0.07, skin)
    oval(0.5, 0.14, 0.105, 0.13, skin)
    for sign in (-1.0, 1.0):
        oval(0.5 + sign * 0.055, 0.09, 0.022, 0.026, Colour(20, 24, 20))
    oval(0.5, 0.54, 0.30, 0.345, rim)
    oval(0.5, 0.54, 0.265, 0.31, shell)
    if pattern == "rings":
        for size, colour in ((0.75, rim), (0.62, shell), (0.36, rim), (0.22, shell)):
            oval(0.5, 0.54, 0.265 * size, 0.31 * size, colour)
    elif pattern == "spots":
        oval(0.5, 0.54, 0.075, 0.085, rim)
        for step in range(6):
            angle = math.pi * step / 3.0
            oval(0.5 + 0.16 * math.sin(angle), 0.54 + 0.19 * math.cos(angle), 0.05, 0.055, rim)
    else:
        corners = [(math.pi * step / 3.0 + math.pi / 6.0) for step in range(6)]
        inner = [
            ((0.5 + 0.13 * math.cos(a)) * side, (0.54 + 0.15 * math.sin(a)) * side) for a in corners
        ]
        outer = [
            ((0.5 + 0.27 * math.cos(a)) * side, (0.54 + 0.315 * math.sin(a)) * side)
            for a in corners
        ]
        width = round(0.02 * side)
        draw.line([*inner, inner[0]], fill=rim, width=width, joint="curve")
        for begin, end in zip(inner, outer, strict=True):
            draw.line([begin, end], fill=rim, width=width)
    small = picture.resize((side // 2, side // 2), Image.Resampling.LANCZOS)
    return np.asarray(small)
