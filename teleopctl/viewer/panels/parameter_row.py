"""One parameter on the page: what its type and its descriptor ask for."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.base.printable import shortened
from teleopctl.node import (
    Parameter,
    ParameterType,
    parameter_value_from_yaml,
    parameter_value_to_python,
)

if TYPE_CHECKING:
    from teleopctl.viewer.page.page import Page

_STEPS = 1000
_MOST_DIGITS = 12
_LONGEST_TEXT = 2000
# Browsers count in floats: beyond this, integers are typed as text.
_MOST_EXACT = 2**53

# Any stands for messages: their classes are made at run time, from definitions.


class ParameterRow:
    """Control of a parameter: a checkbox, a slider for a range, else a text field.

    A value that is being set is not sent again before the answer is there; then the newest is.

    Args:
        page: Where it is added.
        label: What stands before it.
        message: The parameter, as rcl_interfaces/Parameter.
        descriptor: As rcl_interfaces/ParameterDescriptor, or None.
        send: Sets a parameter; calls `accepted` or `refused`.
    """

    def __init__(
        self,
        page: Page,
        label: str,
        message: Any,
        descriptor: Any | None,
        send: Callable[[ParameterRow, Parameter], object],
    ) -> None:
        self._message = message
        self._type = ParameterType(message.value.type)
        self._send = send
        self._is_busy = False
        self._next: Parameter | None = None
        self._bounds = _bounds(self._type, descriptor)
        value = parameter_value_to_python(message.value)
        hint = _hint(self._type, descriptor)
        is_fixed = descriptor is not None and descriptor.read_only
        gui = page.gui
        if self._type is ParameterType.BOOL:
            self._handle: Any = gui.add_checkbox(label, bool(value), hint=hint, disabled=is_fixed)
            self._handle.on_update(page.on(self._moved))
        elif self._bounds is not None and _fits(value, self._bounds):
            low, high, step = self._bounds
            self._handle = gui.add_slider(
                label, low, high, step, value, hint=hint, disabled=is_fixed
            )
            self._handle.precision = min(max(0, -math.floor(math.log10(step))), _MOST_DIGITS)
            self._handle.on_update(page.on(self._moved))
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
            take = page.on(self._entered)
            form.on_submit(lambda _event: take(self._handle.value))

    def show(self, message: Any) -> None:
        """Show the parameter's present value."""
        self._message = message
        if self._is_busy:
            return
        value = parameter_value_to_python(message.value)
        if self._type is ParameterType.BOOL:
            self._handle.value = bool(value)
        elif self._bounds is not None:
            low, high, _ = self._bounds
            self._handle.value = min(max(value, low), high)
        else:
            self._handle.value = parameter_text(message)

    def accepted(self, message: Any) -> None:
        """Handle the node's acceptance of a value."""
        self._message = message
        self._go_on()

    def refused(self) -> None:
        """Handle the node's rejection of a value, by showing the present one again."""
        self._next = None
        self._go_on()

    def switch_off(self) -> None:
        """Disable the control, because the node has gone."""
        self._handle.disabled = True

    def _go_on(self) -> None:
        self._is_busy = False
        following, self._next = self._next, None
        if following is not None:
            self._set(following)
        else:
            self.show(self._message)

    def _moved(self, event: Any) -> None:
        # A value that was set from here comes without a client.
        if event.client is not None:
            self._set(Parameter(self._message.name, self._type, self._handle.value))

    def _entered(self, text: str) -> None:
        if text == parameter_text(self._message):
            return
        name = self._message.name
        try:
            self._set(Parameter(name, *value_from_text(self._type, text)))
        except ValueError:
            # The node says why, and the text is shown again as it was.
            self._set(Parameter.from_parameter_msg(_loose(name, text)))

    def _set(self, parameter: Parameter) -> None:
        if self._is_busy:
            self._next = parameter
            return
        self._is_busy = True
        self._send(self, parameter)


def parameter_text(message: Any) -> str:
    """Return a parameter's value as a user types it; see `value_from_text`.

    Args:
        message: As rcl_interfaces/Parameter.
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
    """A value as YAML, such as ``true``, ``0.5`` and ``"a"``."""
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
    """Parse a typed value for a parameter's type: strings as they are, all else as YAML.

    Returns:
        The type, another one only for a parameter without any, and the value.

    Raises:
        ValueError: It is of another type.
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


def _loose(name: str, text: str) -> Any:
    message = Parameter(name, value="").to_parameter_msg()
    message.value = parameter_value_from_yaml(text)
    return message


def _bounds(type_: ParameterType, descriptor: Any | None) -> tuple[Any, Any, Any] | None:
    """Least, most and step of a slider; None where there is no range."""
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


def _hint(type_: ParameterType, descriptor: Any | None) -> str:
    parts = []
    if descriptor is not None:
        parts += [descriptor.description, descriptor.additional_constraints]
        if descriptor.read_only:
            parts.append("Read only.")
    parts.append(type_.name.lower().replace("_", " "))
    return " · ".join(part.strip() for part in parts if part and part.strip())
