"""Marks the functions that Zenoh calls, so that no interrupt is raised in them.

Zenoh calls back on whichever thread makes something known, which may be the main thread. What is
raised in such a call it reports and forgets, and with it a KeyboardInterrupt.
"""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType, FrameType
from typing import TypeVar

_Function = TypeVar("_Function", bound=Callable[..., object])

_marked: set[CodeType] = set()


def transport_callback(function: _Function) -> _Function:
    """Mark a function that Zenoh calls. Costs nothing in the call."""
    _marked.add(function.__code__)
    return function


def in_transport_callback(frame: FrameType | None) -> bool:
    """Whether a frame belongs to a call from Zenoh."""
    while frame is not None:
        if frame.f_code in _marked:
            return True
        frame = frame.f_back
    return False
