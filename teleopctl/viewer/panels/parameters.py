"""The parameters of any node, to be read and set."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from teleopctl.interfaces import get_message
from teleopctl.node import Parameter, qos_profile_parameter_events
from teleopctl.viewer.html import escaped
from teleopctl.viewer.page.page import Page
from teleopctl.viewer.panels.base import Panel
from teleopctl.viewer.panels.parameter_row import ParameterRow
from teleopctl.viewer.remote.service_calls import ServiceCalls

MOST_ROWS = 150
"""Parameters that are shown at once; a filter leads to the others."""

_NONE = "(choose a node)"
_FEW = 12
_LIST_TYPE = "rcl_interfaces/srv/ListParameters"

# Any stands for messages: their classes are made at run time, from definitions.


class ParametersPanel(Panel):
    """Panel of a node's parameters, with a control that suits each type and descriptor."""

    title: ClassVar[str] = "Parameters"
    icon = "adjustments"

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._node = ""
        self._is_there = False
        # Of the chosen node, by name: its message, and its descriptor.
        self._parameters: dict[str, Any] = {}
        self._descriptors: dict[str, Any] = {}
        self._rows: dict[str, ParameterRow] = {}
        self._groups: list[Any] = []
        self._must_rebuild = False
        # Answers to questions before this one are of no interest any more.
        self._question = 0
        self._end: Callable[[], None] | None = None

    def build(self) -> None:
        """Add the choice of a node, a filter and the place of the parameters."""
        self._choice: Any = self.gui.add_dropdown("Node", (_NONE,))
        self._choice.on_update(self.page.on(lambda _event: self._choose()))
        self._filter: Any = self.gui.add_text("Contains", "", visible=False)
        self._filter.on_update(self.page.on(lambda _event: self._rebuild_soon()))
        self._note = self.gui.add_html("", visible=False)
        self._again = self.gui.add_button("Ask again", visible=False)
        self._again.on_click(self.page.on(lambda _event: self._load()))
        self._place = self.gui.add_folder(None)

    def began(self) -> None:
        """Subscribe to parameter events and offer the nodes of the graph."""
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
        """Unsubscribe from everything."""
        if self._end is not None:
            self._end()
            self._end = None
        self._calls.close()

    def graph_changed(self) -> None:
        """Offer the nodes of the graph, and update the chosen one if it has come or gone."""
        if self._end is not None:
            self._offer_nodes()

    def tick(self) -> None:
        """Apply the filter."""
        if self._must_rebuild:
            self._rebuild()

    # --- which node ---------------------------------------------------------------------------

    def _offer_nodes(self) -> None:
        node = self.page.node
        suffix = "/list_parameters"
        names = {
            name.removesuffix(suffix)
            for name, types in node.get_service_names_and_types()
            if name.endswith(suffix) and _LIST_TYPE in types and node.count_services(name)
        }
        options = (_NONE, *sorted(names | ({self._node} if self._node else set())))
        if options != tuple(self._choice.options):
            self._choice.options = options
        was_there, self._is_there = self._is_there, self._node in names
        if self._node and was_there != self._is_there:
            if self._is_there:
                self._load()
            else:
                self._fail("is gone")

    def _choose(self) -> None:
        chosen = "" if self._choice.value == _NONE else self._choice.value
        if chosen == self._node:
            return
        self._calls.close()
        self._node = chosen
        self._is_there = True
        self._filter.value = ""
        self._load()

    # --- asking -------------------------------------------------------------------------------

    def _load(self) -> None:
        """Ask the chosen node for everything."""
        self._parameters, self._descriptors = {}, {}
        self._rebuild()
        self._again.visible = False
        self._question += 1
        if not self._node:
            self._say("")
            return
        self._say(f"Asking {escaped(self._node)}…")
        self._ask("list_parameters", "ListParameters", self._take_names)

    def _ask(
        self, service: str, type_name: str, then: Callable[[Any], object], **fields: Any
    ) -> None:
        question = self._question

        def take(response: Any) -> None:
            if question == self._question:
                then(response)

        def fail(reason: str) -> None:
            if question == self._question:
                self._fail(f"does not tell its parameters: {reason}")

        self._calls.call(
            f"{self._node}/{service}", f"rcl_interfaces/srv/{type_name}", take, fail, **fields
        )

    def _take_names(self, response: Any) -> None:
        names = sorted(response.result.names)
        if not names:
            self._say(f"{escaped(self._node)} has no parameters.")
            return

        def take_descriptors(described: Any) -> None:
            self._descriptors = {one.name: one for one in described.descriptors}
            self._ask("get_parameters", "GetParameters", take_values, names=names)

        def take_values(got: Any) -> None:
            if len(got.values) == len(names):
                self._show(dict(zip(names, got.values, strict=True)))
                return
            # One without a value spoils the answer for all: each is asked for alone.
            found: dict[str, Any] = {}
            awaited = set(names)
            for name in names:
                self._ask(
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

        self._ask("describe_parameters", "DescribeParameters", take_descriptors, names=names)

    def _show(self, values: dict[str, Any]) -> None:
        made = get_message("rcl_interfaces/msg/Parameter")
        self._parameters.update(
            {name: made(name=name, value=value) for name, value in values.items()}
        )
        self._rebuild_soon()

    def _fail(self, what: str) -> None:
        self._say(f"<b>{escaped(self._node)}</b> {escaped(what)}.")
        self._again.visible = True
        for row in self._rows.values():
            row.switch_off()

    def _say(self, text: str) -> None:
        self._note.content = (
            f'<div style="padding:0 .75em .5em;font-size:14px;line-height:1.4">{text}</div>'
        )
        self._note.visible = bool(text)

    # --- showing ------------------------------------------------------------------------------

    def _rebuild_soon(self) -> None:
        self._must_rebuild = True

    def _rebuild(self) -> None:
        """Make the rows anew: parameters without a group first, each group in a folder."""
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
        told = [*event.new_parameters, *event.changed_parameters]
        deleted = [one.name for one in event.deleted_parameters]
        known = all(
            one.name in self._parameters and one.value.type == self._parameters[one.name].value.type
            for one in told
        )
        if deleted or not known:
            self._load()
            return
        for one in told:
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
                row.accepted(message)
            else:
                refuse(result.reason if result is not None else "it gives no answer")

        def refuse(reason: str) -> None:
            self.page.notify(f"{name} is not set", reason or "The node refuses it.", wrong=True)
            row.refused()

        message = parameter.to_parameter_msg()
        self._calls.call(
            f"{self._node}/set_parameters",
            "rcl_interfaces/srv/SetParameters",
            take,
            refuse,
            parameters=[message],
        )


def _grouped(names: Iterable[str]) -> list[tuple[str, list[str]]]:
    """Names by what stands before their first dot; those without one first."""
    groups: dict[str, list[str]] = {"": []}
    for name in names:
        group, dot, _ = name.partition(".")
        groups.setdefault(group if dot else "", []).append(name)
    return [(group, members) for group, members in groups.items() if members]
