"""Checks of numbers in parameters and requests.

A module of its own: nodes that render read their parameters before they import mujoco, which
chooses its OpenGL backend at import; see `gl_backend`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

# Largest valid number (m, m/s, rad/s, N, N m): a million kilometres.
_LARGEST = 1e9


def invalid_number_reason(numbers: npt.ArrayLike) -> str:
    """Return text on why numbers are invalid (not finite, or beyond 1e9); empty if valid."""
    values = np.asarray(numbers, float)
    if not np.isfinite(values).all():
        return "is not finite"
    return f"is beyond {_LARGEST:g}" if (np.abs(values) > _LARGEST).any() else ""
