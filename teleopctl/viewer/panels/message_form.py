"""Form of a message: a control for each of its fields, from the defaults of its type."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import yaml

from teleopctl.base.printable import shortened
from teleopctl.base.ros_yaml import load_value
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import Shape, message_from_yaml, message_to_yaml

if TYPE_CHECKING:
    import viser

MOST_CONTROLS = 40
"""Largest number of controls; a message with more fields is typed as YAML."""

_STEP = 0.001
_TIME = "builtin_interfaces/msg/Time"
_LARGEST_EXACT = 2**53

# Any: messages, whose classes are created from definitions at run time, and viser's handles.


class MessageForm:
    """Controls for the fields of a message, added where the GUI's context is.

    Stamps are left out: they are the time at which the message is sent.

    Args:
        gui: The viser GUI.
        message_class: Class of the message.
    """

    def __init__(self, gui: viser.GuiApi, message_class: Any) -> None:
        self._class = message_class
        self._controls: dict[str, Any] = {}
        self._stamps: list[str] = []
        prototype = message_class()
        fields = list(_fields_of(prototype, ""))
        self._stamps = [path for path, _, kind in fields if kind == _TIME]
        fields = [field for field in fields if field[2] != _TIME]
        self._text: Any = None
        if len(fields) > MOST_CONTROLS:
            self._text = gui.add_text("YAML", message_to_yaml(prototype), multiline=True)
        else:
            for path, value, kind in fields:
                self._controls[path] = _control(gui, path, value, kind)

    def message(self, now_ns: int) -> Any:
        """Return the message that the controls describe.

        Args:
            now_ns: Time of the stamps in nanoseconds.

        Raises:
            UsageError: A text is not YAML, or does not fit its field.
        """
        if self._text is not None:
            return message_from_yaml(self._class, self._text.value, now_ns)
        values: dict[str, Any] = {}
        for path in self._stamps:
            _put(values, path, "now")
        for path, control in self._controls.items():
            value = control.value
            is_yaml = isinstance(value, str) and control.hint.startswith(_YAML)
            _put(values, path, _value_of(path, value) if is_yaml else value)
        return message_from_yaml(self._class, values, now_ns)


_YAML = "YAML of "


def _fields_of(message: Any, above: str) -> Iterator[tuple[str, Any, str]]:
    """Yield path, value and type of each field; nested messages that are no lists are entered."""
    for field in message.__definition__.fields:
        value, kind = getattr(message, field.attribute), field.type
        path = f"{above}{field.attribute}"
        is_single = kind.shape is Shape.SINGLE
        if is_single and kind.is_nested and value.TYPE_NAME != _TIME:
            yield from _fields_of(value, f"{path}.")
        else:
            yield path, value, _TIME if is_single and kind.is_nested else str(kind.base)


def _control(gui: viser.GuiApi, path: str, value: Any, kind: str) -> Any:
    if isinstance(value, bool):
        return gui.add_checkbox(path, value, hint=kind)
    if isinstance(value, int) and abs(value) < _LARGEST_EXACT:
        return gui.add_number(path, value, step=1, hint=kind)
    if isinstance(value, float):
        return gui.add_number(path, value, step=_STEP, hint=kind)
    if isinstance(value, str):
        return gui.add_text(path, value, hint=kind)
    values = value.tolist() if hasattr(value, "tolist") else value
    return gui.add_text(path, str(values), hint=f"{_YAML}{kind}[], such as [1, 2]")


def _value_of(path: str, text: str) -> Any:
    try:
        return load_value(text)
    except (yaml.YAMLError, TeleopctlError) as error:
        raise UsageError(f"{path}: {shortened(text)} is not YAML") from error


def _put(values: dict[str, Any], path: str, value: Any) -> None:
    *above, last = path.split(".")
    for part in above:
        values = values.setdefault(part, {})
    values[last] = value
