"""Panel of a node's parameters, with a control for each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from teleopctl.base.printable import shortened
from teleopctl.interfaces import get_message
from teleopctl.node import (
    Parameter,
    ParameterType,
    parameter_value_from_yaml,
    parameter_value_to_python,
    qos_profile_parameter_events,
)
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.service_calls import ServiceCalls, servers_of

_STEPS = 1000
_MOST_DIGITS = 12
_LONGEST_TEXT = 2000
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
        send: Function that sets a parameter, and later calls `on_accepted` or `on_rejected`.
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

    def show(self, message: Any) -> None:
        """Show the value of a Parameter message, unless a value is being set.

        Args:
            message: The rcl_interfaces/Parameter with the value.
        """
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


def _hint(type_: ParameterType, descriptor: Any | None) -> str:
    parts = []
    if descriptor is not None:
        parts += [descriptor.description, descriptor.additional_constraints]
        if descriptor.read_only:
            parts.append("Read only.")
    parts.append(type_.name.lower().replace("_", " "))
    return " · ".join(part.strip() for part in parts if part and part.strip())


MOST_ROWS = 150
"""Largest number of parameters shown at once; a filter finds the others."""

_NONE = "(choose a node)"
_FEW = 12
_LIST_TYPE = "rcl_interfaces/srv/ListParameters"


class ParametersPanel(Panel):
    """Panel of a node's parameters, with a control for each by type and descriptor."""

    title: ClassVar[str] = "Parameters"
    icon = "adjustments"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._node = ""
        self._is_there = False
        # Parameters and descriptors of the selected node, by parameter name.
        self._parameters: dict[str, Any] = {}
        self._descriptors: dict[str, Any] = {}
        self._rows: dict[str, ParameterRow] = {}
        self._groups: list[Any] = []
        self._must_rebuild = False
        # Responses to requests of an earlier number are ignored.
        self._request_number = 0
        self._end: Callable[[], None] | None = None

    def build(self) -> None:
        """Add the choice of a node, a filter and the folder of parameters."""
        self._choice: Any = self.gui.add_dropdown("Node", (_NONE,))
        self._choice.on_update(self.page.on_node_thread(lambda _event: self._choose()))
        self._filter: Any = self.gui.add_text("Contains", "", visible=False)
        self._filter.on_update(self.page.on_node_thread(lambda _event: self._rebuild_soon()))
        self._note = self.gui.add_html("", visible=False)
        self._retry = self.gui.add_button("Request again", visible=False)
        self._retry.on_click(self.page.on_node_thread(lambda _event: self._load()))
        self._place = self.gui.add_folder(None)

    def began(self) -> None:
        """Subscribe to parameter events, and request the chosen node's parameters."""
        self._end = self.page.stage.subscribe(
            "/parameter_events",
            "rcl_interfaces/msg/ParameterEvent",
            self._take_event,
            qos_profile_parameter_events,
        )
        self._offer_nodes()
        if self._node:
            self._load()

    def ended(self) -> None:
        """Unsubscribe from parameter events, and drop pending calls."""
        if self._end is not None:
            self._end()
            self._end = None
        self._calls.close()

    def graph_changed(self) -> None:
        """Update the offered nodes; reload or disable the chosen node's parameters."""
        if self._end is not None:
            self._offer_nodes()

    def tick(self) -> None:
        """Rebuild the rows after the filter or the parameters have changed."""
        if self._must_rebuild:
            self._rebuild()

    # --- selection of the node ----------------------------------------------------------------

    def _offer_nodes(self) -> None:
        names = set(servers_of(self.page.node, "list_parameters", _LIST_TYPE))
        options = (_NONE, *sorted(names | ({self._node} if self._node else set())))
        if options != tuple(self._choice.options):
            self._choice.options = options
        was_there, self._is_there = self._is_there, self._node in names
        if self._node and was_there != self._is_there:
            if self._is_there:
                self._load()
            else:
                self._fail("has gone")

    def _choose(self) -> None:
        chosen = "" if self._choice.value == _NONE else self._choice.value
        if chosen == self._node:
            return
        self._calls.close()
        self._node = chosen
        self._is_there = True
        self._filter.value = ""
        self._load()

    # --- requesting ---------------------------------------------------------------------------

    def _load(self) -> None:
        """Request names, descriptors and values of the chosen node's parameters."""
        self._parameters, self._descriptors = {}, {}
        self._rebuild()
        self._retry.visible = False
        self._request_number += 1
        if not self._node:
            self._say("")
            return
        self._say(f"Waiting for {escaped_html(self._node)}…")
        self._call("list_parameters", "ListParameters", self._take_names)

    def _call(
        self, service: str, type_name: str, then: Callable[[Any], object], **fields: Any
    ) -> None:
        number = self._request_number

        def take(response: Any) -> None:
            if number == self._request_number:
                then(response)

        def fail(reason: str) -> None:
            if number == self._request_number:
                self._fail(f"does not send its parameters: {reason}")

        self._calls.call(
            f"{self._node}/{service}", f"rcl_interfaces/srv/{type_name}", take, fail, **fields
        )

    def _take_names(self, response: Any) -> None:
        names = sorted(response.result.names)
        if not names:
            self._say(f"{escaped_html(self._node)} has no parameters.")
            return

        def take_descriptors(described: Any) -> None:
            self._descriptors = {one.name: one for one in described.descriptors}
            self._call("get_parameters", "GetParameters", take_values, names=names)

        def take_values(got: Any) -> None:
            if len(got.values) == len(names):
                self._show(dict(zip(names, got.values, strict=True)))
                return
            # A parameter without a value empties the whole response: each is requested alone.
            found: dict[str, Any] = {}
            awaited = set(names)
            for name in names:
                self._call(
                    "get_parameters", "GetParameters", one(name, found, awaited), names=[name]
                )

        def one(name: str, found: dict[str, Any], awaited: set[str]) -> Callable[[Any], None]:
            def take(got: Any) -> None:
                if got.values:
                    found[name] = got.values[0]
                awaited.discard(name)
                if not awaited:
                    self._show(found)

            return take

        self._call("describe_parameters", "DescribeParameters", take_descriptors, names=names)

    def _show(self, values: dict[str, Any]) -> None:
        made = get_message("rcl_interfaces/msg/Parameter")
        self._parameters.update(
            {name: made(name=name, value=value) for name, value in values.items()}
        )
        self._rebuild_soon()

    def _fail(self, what: str) -> None:
        self._say(f"<b>{escaped_html(self._node)}</b> {escaped_html(what)}.")
        self._retry.visible = True
        for row in self._rows.values():
            row.disable()

    def _say(self, text: str) -> None:
        self._note.content = note_html(text)
        self._note.visible = bool(text)

    # --- showing ------------------------------------------------------------------------------

    def _rebuild_soon(self) -> None:
        self._must_rebuild = True

    def _rebuild(self) -> None:
        """Replace all rows: parameters without a group first, each group in a folder."""
        self._must_rebuild = False
        for handle in self._groups:
            handle.remove()
        self._groups, self._rows = [], {}
        wanted = self._filter.value.lower()
        names = [name for name in self._parameters if wanted in name.lower()]
        for group, members in _grouped(sorted(names)[:MOST_ROWS]):
            with self._place:
                place: Any = self.gui.add_folder(
                    group or None, expand_by_default=bool(wanted) or not group
                )
            self._groups.append(place)
            with place:
                for name in members:
                    self._rows[name] = ParameterRow(
                        self.page,
                        name.removeprefix(f"{group}.") if group else name,
                        self._parameters[name],
                        self._descriptors.get(name),
                        self._set,
                    )
        self._filter.visible = len(self._parameters) > _FEW
        if self._parameters:
            more = len(names) - MOST_ROWS
            self._say(f"{more} more: type a part of a name above." if more > 0 else "")

    def _take_event(self, event: Any) -> None:
        if event.node != self._node or not self._parameters:
            return
        changed = [*event.new_parameters, *event.changed_parameters]
        deleted = [one.name for one in event.deleted_parameters]
        known = all(
            one.name in self._parameters and one.value.type == self._parameters[one.name].value.type
            for one in changed
        )
        if deleted or not known:
            self._load()
            return
        for one in changed:
            self._parameters[one.name] = one
            if one.name in self._rows:
                self._rows[one.name].show(one)

    # --- setting ------------------------------------------------------------------------------

    def _set(self, row: ParameterRow, parameter: Parameter) -> None:
        name = parameter.name

        def take(response: Any) -> None:
            result = response.results[0] if response.results else None
            if result is not None and result.successful:
                self._parameters[name] = message
                row.on_accepted(message)
            else:
                refuse(result.reason if result is not None else "it sent no result")

        def refuse(reason: str) -> None:
            self.page.notify(f"{name} is not set", reason or "The node rejected it.", wrong=True)
            row.on_rejected()

        message = parameter.to_parameter_msg()
        self._calls.call(
            f"{self._node}/set_parameters",
            "rcl_interfaces/srv/SetParameters",
            take,
            refuse,
            parameters=[message],
        )


def _grouped(names: Iterable[str]) -> list[tuple[str, list[str]]]:
    """Return names grouped by their part before the first dot; those without one first."""
    groups: dict[str, list[str]] = {"": []}
    for name in names:
        group, dot, _ = name.partition(".")
        groups.setdefault(group if dot else "", []).append(name)
    return [(group, members) for group, members in groups.items() if members]
