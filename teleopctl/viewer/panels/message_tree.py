"""HTML tree of a message: nested fields fold, and a click on a number plots it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any, NamedTuple

from teleopctl.interfaces import Shape
from teleopctl.viewer.html import escaped_html

MOST_LINES = 300
"""Largest number of lines of a tree; what follows is left out."""

MOST_ELEMENTS = 20
"""Largest number of elements of an array that are shown."""

_LONGEST_VALUE = 160
# Short arrays, such as quaternions and colours, are open at first; so are two levels of messages.
_FEW = 4
_LEVELS_OPEN = 2
_INDENT_EM = 1.0
_OPEN, _CLOSED = "\u25be", "\u25b8"
_LINE = (
    '<div style="padding-left:{indent:g}em;white-space:nowrap;overflow:hidden;'
    'text-overflow:ellipsis"{title}><span {mark}>{text}</span></div>'
)

# Any: messages, whose classes are created from definitions at run time.


class _Line(NamedTuple):
    """Line of a tree: level, text as HTML, action of a click, and the whole value as a tooltip."""

    level: int
    text: str
    action: str = ""
    value: str = ""


def message_tree(
    message: Any, flipped: Collection[str], mark: Callable[[str], str]
) -> tuple[str, int]:
    """Return a message as a tree in HTML, and the number of lines that are left out.

    Args:
        message: The message.
        flipped: Paths of fields that the user has opened or closed, against the default.
        mark: Function that returns the attributes of an element which is clicked for an action:
            ``flip PATH`` or ``plot PATH``.
    """
    lines = list(_lines_of(message, "", 0, flipped))
    shown = [
        _LINE.format(
            indent=line.level * _INDENT_EM,
            text=line.text,
            mark=mark(line.action) if line.action else "",
            title=f' title="{line.value}"' if line.value else "",
        )
        for line in lines[:MOST_LINES]
    ]
    return "".join(shown), len(lines) - len(shown)


def _lines_of(message: Any, above: str, level: int, flipped: Collection[str]) -> Iterator[_Line]:
    for field in message.__definition__.fields:
        value, kind = getattr(message, field.attribute), field.type
        path = f"{above}.{field.attribute}" if above else field.attribute
        name = escaped_html(field.name)
        is_number = kind.is_numeric or kind.base == "bool"
        if kind.shape is Shape.SINGLE:
            if kind.is_nested:
                is_open = (level < _LEVELS_OPEN - 1 and field.name != "header") != (path in flipped)
                yield _branch(level, name, escaped_html(str(kind.base)), path, is_open=is_open)
                if is_open:
                    yield from _lines_of(value, path, level + 1, flipped)
            else:
                yield _leaf(level, name, value, f"plot {path}" if is_number else "")
            continue
        count = len(value)
        is_open = (0 < count <= _FEW and level < _LEVELS_OPEN) != (path in flipped)
        yield _branch(
            level, name, f"{escaped_html(str(kind.base))}[{count}]", path, is_open=is_open
        )
        if not is_open:
            continue
        for number in range(min(count, MOST_ELEMENTS)):
            element, place = value[number], f"{path}[{number}]"
            if kind.is_nested:
                is_entered = (count <= _FEW) != (place in flipped)
                yield _branch(level + 1, f"[{number}]", "", place, is_open=is_entered)
                if is_entered:
                    yield from _lines_of(element, place, level + 2, flipped)
            else:
                yield _leaf(level + 1, f"[{number}]", element, f"plot {place}" if is_number else "")
        if count > MOST_ELEMENTS:
            yield _Line(level + 1, f"… {count - MOST_ELEMENTS} more")


def _branch(level: int, name: str, kind: str, path: str, *, is_open: bool) -> _Line:
    sign = _OPEN if is_open else _CLOSED
    text = f'{sign} <b>{name}</b> <span style="opacity:.6">{kind}</span>'
    return _Line(level, text, f"flip {path}")


def _leaf(level: int, name: str, value: Any, action: str) -> _Line:
    text = escaped_html(_text_of(value), _LONGEST_VALUE)
    return _Line(level, f'<span style="opacity:.7">{name}</span> {text}', action, text)


def _text_of(value: Any) -> str:
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
