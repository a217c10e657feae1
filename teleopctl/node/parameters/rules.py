"""Rules of parameters: the range of a number, the names below a prefix."""

from __future__ import annotations

import math
from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor


def range_problem(name: str, value: object, descriptor: ParameterDescriptor) -> str | None:
    """Return why a number violates its descriptor's range; None if it does not."""
    ranges = descriptor.integer_range if isinstance(value, int) else descriptor.floating_point_range
    if isinstance(value, bool) or not isinstance(value, int | float) or not ranges:
        return None
    allowed = ranges[0]
    if value < allowed.from_value or value > allowed.to_value:
        # The ends themselves may be unreachable for a computer's fractions.
        ends = (allowed.from_value, allowed.to_value)
        if not any(math.isclose(value, end, rel_tol=1e-9) for end in ends):
            return (
                f"Parameter {name} out of range. Min: {allowed.from_value}, "
                f"Max: {allowed.to_value}, value: {value}"
            )
    if allowed.step:
        steps = (value - allowed.from_value) / allowed.step
        on_end = math.isclose(value, allowed.to_value, rel_tol=1e-9)
        if not on_end and not math.isclose(steps, round(steps), abs_tol=1e-9):
            return f"The parameter value for {name} is not a valid step. Step: {allowed.step}"
    return None


def is_listed(name: str, prefixes: Sequence[str], depth: int) -> bool:
    """Return whether ListParameters lists a name; depth 0 is without limit."""
    if not prefixes:
        return depth == 0 or name.count(".") < depth
    for prefix in prefixes:
        if name == prefix:
            return True
        if name.startswith(f"{prefix}."):
            below = name[len(prefix) + 1 :]
            if depth == 0 or below.count(".") < depth:
                return True
    return False
