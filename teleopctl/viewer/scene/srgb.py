"""Colours as screens have them, and as the amounts of light that glTF and viser's batches take.

Source: IEC 61966-2-1.
"""

from __future__ import annotations

import math

import numpy as np

from teleopctl.viewer.scene.drawing import Floats


def linear_light(shades: Floats) -> Floats:
    """Return linear light intensities, from 0 to 1, of sRGB values."""
    return np.where(shades <= 0.04045, shades / 12.92, ((shades + 0.055) / 1.055) ** 2.4)


def light_of(shade: float) -> float:
    """Return the linear light intensity of one sRGB value, clamped to 0 to 1."""
    shade = min(max(shade, 0.0), 1.0)
    return shade / 12.92 if shade <= 0.04045 else math.pow((shade + 0.055) / 1.055, 2.4)


def shade_of(light: float) -> float:
    """Return the sRGB value of a linear light intensity, clamped to 0 to 1."""
    light = min(max(light, 0.0), 1.0)
    return light * 12.92 if light <= 0.0031308 else 1.055 * math.pow(light, 1 / 2.4) - 0.055
