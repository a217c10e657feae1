"""Panel of a node's parameters, with a control for each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, ClassVar, TypeAlias

from teleopctl.interfaces import get_message
from teleopctl.node import Parameter, qos_profile_parameter_events
from teleopctl.viewer.html import escaped_html, note_html
from teleopctl.viewer.panels.base import Page, Panel
from teleopctl.viewer.panels.parameter_row import ParameterRow
from teleopctl.viewer.service_calls import ServiceCalls, servers_of

# Any: messages, whose classes are created from definitions at run time.

MOST_ROWS = 150
"""Largest number of parameters shown at once; a filter finds the others."""

_NONE = "(choose a node)"
_FEW = 12
_LIST_TYPE = "rcl_interfaces/srv/ListParameters"


class ParametersPanel(Panel):
    """Panel of a node's parameters, with a control for each by type and descriptor."""

    title: ClassVar[str] = "Parameters"
    icon = "adjustments"
    is_per_browser = True

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._calls = ServiceCalls(page)
        self._node = ""
        self._is_there = False
        # Parameters and descriptors of the selected node, by parameter name.
        self._parameters: dict[str, Any] = {}
        self._descriptors: dict[str, Any] = {}
        # Parameters as they were when this page first saw them, for "Reset", by node and name.
        self._first: dict[tuple[str, str], Any] = {}
        self._rows: dict[str, ParameterRow] = {}
        self._root: Any = None
        self._must_rebuild = False
        # Responses to requests of an earlier number are ignored.
        self._request_number = 0
        self._end: Callable[[], None] | None = None

    def build(self) -> None:
        """Add the choice of a node, a filter and the folder of parameters."""
        self._choice: Any = self.gui.add_dropdown("Node", (_NONE,))
        self._choice.on_update(self.page.on_node_thread(lambda _event: self._choose()))
        self.keep("node", self._choice, has_more=True)
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
                self._first = {key: one for key, one in self._first.items() if key[0] != self._node}
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
        for name, message in self._parameters.items():
            self._first.setdefault((self._node, name), message)
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
        if self._root is not None:
            self._root.remove()
        self._rows = {}
        wanted = self._filter.value.lower()
        names = sorted(name for name in self._parameters if wanted in name.lower())
        tree = parameter_tree(names[:MOST_ROWS])
        with self._place:
            self._root = self.gui.add_folder(None)
        with self._root:
            self._add_rows(tree, "", is_open=bool(wanted) or len(tree) == 1)
        self._filter.visible = len(self._parameters) > _FEW
        if self._parameters:
            more = len(names) - MOST_ROWS
            self._say(f"{more} more: type a part of a name above." if more > 0 else "")

    def _add_rows(self, tree: ParameterTree, above: str, *, is_open: bool) -> None:
        """Add the controls of one level of the tree, and a folder for each group."""
        for part, inner in tree.items():
            name = f"{above}{part}"
            if inner is not None:
                with self.gui.add_folder(part, expand_by_default=is_open):
                    self._add_rows(inner, f"{name}.", is_open=is_open)
                continue
            self._rows[name] = ParameterRow(
                self.page,
                part,
                self._parameters[name],
                self._descriptors.get(name),
                self._first.get((self._node, name), self._parameters[name]),
                self._set,
            )

    def show_of(self, name: str) -> None:
        """Show the parameters of a node.

        Args:
            name: Full name of the node.
        """
        if name not in self._choice.options:
            self._choice.options = (*self._choice.options, name)
        self._choice.value = name
        self._choose()

    def clicked(self, client: Any, what: str) -> None:
        """Set a parameter to its first value again.

        Args:
            client: viser's handle of the browser.
            what: ``reset`` and the name of the parameter.
        """
        del client
        row = self._rows.get(what.removeprefix("reset "))
        if row is not None:
            row.reset()

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


ParameterTree: TypeAlias = "dict[str, ParameterTree | None]"
"""Names of parameters by their parts between dots; None for a parameter."""


def parameter_tree(names: Iterable[str]) -> ParameterTree:
    """Return names as a tree by their dots: parameters first, then groups.

    A group of one is no group: its parameter has a name with a dot.

    Args:
        names: Names of parameters.
    """
    alone: ParameterTree = {}
    groups: dict[str, list[str]] = {}
    for name in names:
        part, dot, rest = name.partition(".")
        if dot and part and rest:
            groups.setdefault(part, []).append(rest)
        else:
            alone[name] = None
    tree: ParameterTree = {}
    for part, rests in groups.items():
        if len(rests) == 1 or part in alone:
            alone.update({f"{part}.{rest}": None for rest in rests})
        else:
            tree[part] = parameter_tree(rests)
    return {**alone, **tree}
