"""Numbers and names as short as a table needs them."""

from __future__ import annotations

_UNITS = ("B", "kB", "MB", "GB", "TB")
_THOUSAND = 1000.0


def percent(value: float | None) -> str:
    """Return a percentage with one decimal."""
    return "" if value is None else f"{value:.1f}"


def size(value: float | None, per: str = "") -> str:
    """Return a size in a suitable unit: ``1.2 MB``."""
    if value is None:
        return ""
    for unit in _UNITS:
        if value < _THOUSAND or unit == _UNITS[-1]:
            break
        value /= _THOUSAND
    digits = 0 if unit == "B" else 1
    return f"{value:.{digits}f} {unit}{per}"


def rate(value: float) -> str:
    """Return a rate in Hz with about three digits."""
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def age(seconds: float | None) -> str:
    """Return a duration in a suitable unit, from milliseconds to hours."""
    if seconds is None:
        return ""
    if seconds < 1.0:
        return f"{seconds * 1000:.0f} ms"
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    minutes = int(seconds) // 60
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def work(microseconds: float | None) -> str:
    """Return a duration in microseconds or, from a thousand on, in milliseconds."""
    if microseconds is None:
        return ""
    if microseconds < _THOUSAND:
        return f"{microseconds:.0f} µs"
    return f"{microseconds / _THOUSAND:.1f} ms"


def shortened(name: str, width: int) -> str:
    """Return a name shortened at its beginning to so many characters."""
    return name if len(name) <= width else f"…{name[len(name) - width + 1 :]}"
