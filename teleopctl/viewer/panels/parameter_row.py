"""Control for one parameter of a node, in the panel of parameters."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.base.printable import shortened
from teleopctl.interfaces import parameter_value_to_python
from teleopctl.node import Parameter, ParameterType, parameter_value_from_yaml
from teleopctl.viewer.client_tracker import click_mark
from teleopctl.viewer.html import escaped_html, note_html

if TYPE_CHECKING:
    from teleopctl.viewer.panels.base import Page

_STEPS = 1000
_MOST_DIGITS = 12
_LONGEST_TEXT = 2000
_LONGEST_FIRST = 60
# A unit at the end of a description: "[m/s]", "(rad)" or "in m".
_UNIT = re.compile(r"(?:[\[(]([^\s\[\]()]{1,12})[\])]|\bin ([\w/^²³%°]{1,8}))\.?\s*$")
# Browsers store numbers as floats: larger integers are typed as text.
_MOST_EXACT = 2**53

# Any: messages, whose classes are created from definitions at run time.


class ParameterRow:
    """Control for one parameter: a checkbox, a slider for a range, else a text field.

    While a value is being set, only the newest further value is kept, to be sent after the
    response.

    Args:
        page: The viewer's node.
        label: Label of the control.
        message: The parameter's rcl_interfaces/Parameter.
        descriptor: The parameter's rcl_interfaces/ParameterDescriptor, or None.
        first: The parameter's rcl_interfaces/Parameter that *Reset* sets again.
        send: Function that sets a parameter, and later calls `on_accepted` or `on_rejected`.
    """

    def __init__(
        self,
        page: Page,
        label: str,
        message: Any,
        descriptor: Any | None,
        first: Any,
        send: Callable[[ParameterRow, Parameter], object],
    ) -> None:
        self._gui = page.gui
        self._message, self._first = message, first
        # Line below the control with the first value, once the value is another.
        self._was: Any = None
        self._type = ParameterType(message.value.type)
        self._send = send
        self._is_busy = False
        self._next: Parameter | None = None
        self._bounds = _bounds(self._type, descriptor)
        value = parameter_value_to_python(message.value)
        hint = _hint(self._type, descriptor)
        is_fixed = descriptor is not None and descriptor.read_only
        gui = page.gui
        label = f"{label} {unit}" if (unit := _unit(descriptor)) else label
        is_bool = self._type is ParameterType.BOOL
        if is_bool:
            self._handle: Any = gui.add_checkbox(label, bool(value), hint=hint, disabled=is_fixed)
            self._handle.on_update(page.on_node_thread(self._moved))
        elif self._bounds is not None and _fits(value, self._bounds):
            low, high, step = self._bounds
            self._handle = gui.add_slider(
                label, low, high, step, value, hint=hint, disabled=is_fixed
            )
            self._handle.precision = min(max(0, -math.floor(math.log10(step))), _MOST_DIGITS)
            self._handle.on_update(page.on_node_thread(self._moved))
        else:
            self._bounds = None
            text = parameter_text(message)
            too_long = len(text) > _LONGEST_TEXT
            with gui.add_form(None) as form:
                self._handle = gui.add_text(
                    label,
                    text[:_LONGEST_TEXT] + "…" if too_long else text,
                    multiline="\n" in text,
                    hint="Too long to be changed here" if too_long else hint,
                    disabled=is_fixed or too_long,
                )
            take = page.on_node_thread(self._entered)
            form.on_submit(lambda _event: take(self._handle.value))
        self._order: float = self._handle.order if self._bounds or is_bool else form.order
        self._show_first()

    def reset(self) -> None:
        """Set the first value again."""
        self._set(Parameter.from_parameter_msg(self._first))

    def _show_first(self) -> None:
        """Show the first value below the control, and a way back to it, if the value is another."""
        is_changed = parameter_text(self._message) != parameter_text(self._first)
        if is_changed and self._was is None:
            text = escaped_html(parameter_text(self._first), _LONGEST_FIRST)
            mark = click_mark("parameters", f"reset {self._first.name}")
            # The element stands between this control and the next one, whose order is 1 more.
            self._was = self._gui.add_html(
                note_html(f"was {text} · <u {mark}>Reset</u>"), order=self._order + 0.5
            )
        if self._was is not None:
            self._was.visible = is_changed

    def show(self, message: Any) -> None:
        """Show the value of a Parameter message, unless a value is being set.

        Args:
            message: The rcl_interfaces/Parameter with the value.
        """
        self._message = message
        if self._is_busy:
            return
        self._show_first()
        value = parameter_value_to_python(message.value)
        if self._type is ParameterType.BOOL:
            self._handle.value = bool(value)
        elif self._bounds is not None:
            low, high, _ = self._bounds
            self._handle.value = min(max(value, low), high)
        else:
            self._handle.value = parameter_text(message)

    def on_accepted(self, message: Any) -> None:
        """Show an accepted value, or send the next one; called after the node's response."""
        self._message = message
        self._send_next()

    def on_rejected(self) -> None:
        """Drop a waiting value, and show the present one; called after the node's rejection."""
        self._next = None
        self._send_next()

    def disable(self) -> None:
        """Disable the control; called when the node has gone or does not respond."""
        self._handle.disabled = True

    def _send_next(self) -> None:
        self._is_busy = False
        following, self._next = self._next, None
        if following is not None:
            self._set(following)
        else:
            self.show(self._message)

    def _moved(self, event: Any) -> None:
        # The event of a value that was set by this process has no client.
        if event.client is not None:
            self._set(Parameter(self._message.name, self._type, self._handle.value))

    def _entered(self, text: str) -> None:
        if text == parameter_text(self._message):
            return
        name = self._message.name
        try:
            self._set(Parameter(name, *value_from_text(self._type, text)))
        except ValueError:
            # The node rejects the value and returns the reason.
            self._set(Parameter.from_parameter_msg(_parameter_of_text(name, text)))

    def _set(self, parameter: Parameter) -> None:
        if self._is_busy:
            self._next = parameter
            return
        self._is_busy = True
        self._send(self, parameter)


def parameter_text(message: Any) -> str:
    """Return the value of a Parameter message as text; inverse of `value_from_text`.

    Args:
        message: The rcl_interfaces/Parameter.
    """
    value: Any = parameter_value_to_python(message.value)
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    if isinstance(value, list | tuple) or hasattr(value, "tolist"):
        return f"[{', '.join(_scalar(element) for element in value)}]"
    return _scalar(value)


def _scalar(value: Any) -> str:
    """Return a scalar as YAML, such as ``true``, ``0.5`` and ``"a"``."""
    import yaml

    if isinstance(value, bytes):
        return str(value[0])
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        quoted = yaml.dump(value, default_style='"', allow_unicode=True, width=math.inf)
        return str(quoted).rstrip("\n")
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: ".inf", -math.inf: "-.inf"}.get(value, ".nan")
    return repr(value)


def value_from_text(type_: ParameterType, text: str) -> tuple[ParameterType, Any]:
    """Parse a text field's text for a parameter type, as YAML unless string; return type and value.

    Returns:
        The type, which differs from ``type_`` only if that is NOT_SET, and the value.

    Raises:
        ValueError: The value is of another type.
    """
    if type_ is ParameterType.STRING:
        return type_, text
    value = parameter_value_to_python(parameter_value_from_yaml(text))
    if type_ is ParameterType.NOT_SET:
        return ParameterType.from_parameter_value(value), value
    if type_ is ParameterType.DOUBLE and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type_ is ParameterType.DOUBLE_ARRAY and isinstance(value, list):
        value = [float(element) for element in value]
    if type_ is ParameterType.BYTE_ARRAY and isinstance(value, list):
        value = [bytes([element]) for element in value]
    if not type_.check(value):
        raise ValueError(f"{shortened(text)} is no {type_.name}")
    return type_, value


def _parameter_of_text(name: str, text: str) -> Any:
    message = Parameter(name, value="").to_parameter_msg()
    message.value = parameter_value_from_yaml(text)
    return message


def _bounds(type_: ParameterType, descriptor: Any | None) -> tuple[Any, Any, Any] | None:
    """Return smallest and largest value and step of a slider, or None without range."""
    if descriptor is None:
        return None
    if type_ is ParameterType.INTEGER and descriptor.integer_range:
        whole = descriptor.integer_range[0]
        low, high = int(whole.from_value), int(whole.to_value)
        if not -_MOST_EXACT < low < high < _MOST_EXACT:
            return None
        return low, high, min(max(1, int(whole.step)), high - low)
    if type_ is ParameterType.DOUBLE and descriptor.floating_point_range:
        real = descriptor.floating_point_range[0]
        least, most, step = real.from_value, real.to_value, real.step
        if not (least < most and math.isfinite(most - least)):
            return None
        if not 0.0 < step <= most - least:
            step = 10.0 ** math.floor(math.log10((most - least) / _STEPS))
        return float(least), float(most), float(step)
    return None


def _fits(value: Any, bounds: tuple[Any, Any, Any]) -> bool:
    return isinstance(value, int | float) and bool(bounds[0] <= value <= bounds[1])


def _unit(descriptor: Any | None) -> str:
    """Return the unit at the end of a description: ``[m/s]``; descriptors have no field for it."""
    found = None if descriptor is None else _UNIT.search(descriptor.description)
    return f"[{found[1] or found[2]}]" if found else ""


def _range_text(descriptor: Any) -> str:
    ranges = (*descriptor.integer_range, *descriptor.floating_point_range)
    return f"from {ranges[0].from_value:g} to {ranges[0].to_value:g}" if ranges else ""


def _hint(type_: ParameterType, descriptor: Any | None) -> str:
    parts = []
    if descriptor is not None:
        parts += [descriptor.description, descriptor.additional_constraints]
        parts.append(_range_text(descriptor))
        if descriptor.read_only:
            parts.append("Read only.")
    parts.append(type_.name.lower().replace("_", " "))
    return " · ".join(part.strip() for part in parts if part and part.strip())
