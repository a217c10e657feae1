"""State of a controller that exports none: attributes that its activation sets.

What ``on_activate`` sets is what changes while the controller runs: a phase, a reference, a time.
Attributes of other callbacks follow from the code and the parameters, so the new code's are used.
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable

_NUMBERS_AND_TEXTS = (bool, int, float, str)


def attributes_set_by(instance: object, function: Callable[[], object]) -> set[str]:
    """Call a function; return the names of the attributes that it sets on an object.

    Args:
        instance: The object. While the function runs, its class is a subclass that records; none
            are recorded if Python cannot exchange the object's class.
        function: The function; an exception of it is passed on.
    """
    names: set[str] = set()
    original = type(instance)

    def record(self: object, name: str, value: object) -> None:
        names.add(name)
        original.__setattr__(self, name, value)

    try:
        recording = type(
            original.__name__,
            (original,),
            {"__setattr__": record, "__module__": original.__module__},
        )
        instance.__class__ = recording
    except TypeError:  # a class with a layout of its own, or one that must not be derived from
        function()
        return names
    try:
        function()
    finally:
        instance.__class__ = original
    return names


def copy_plain_attributes(source: object, target: object, names: set[str]) -> None:
    """Copy numbers, texts, and lists of these to an object with a like value, or with None."""
    for name in names:
        value, present = (vars(one).get(name) for one in (source, target))
        if _is_plain(value) and (present is None or type(present) is type(value)):
            setattr(target, name, copy.copy(value))


def _is_plain(value: object) -> bool:
    if isinstance(value, (list, tuple, deque)):
        return all(map(_is_plain, value))
    if isinstance(value, dict):
        return all(map(_is_plain, value.values()))
    # An array, without importing numpy.
    return isinstance(value, _NUMBERS_AND_TEXTS) or type(value).__name__ == "ndarray"
