"""Parameters of all nodes for Foxglove clients, named ``/node.parameter``."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

from foxglove.websocket import Parameter as RemoteParameter, ParameterType as RemoteType

from teleopctl.errors import UnavailableError
from teleopctl.interfaces import get_message, parameter_value_to_python
from teleopctl.node import (
    Node,
    Parameter,
    ParameterType,
    Subscription,
    call_parameter_services,
    qos_profile_parameter_events,
)
from teleopctl.nodes.foxglove_bridge.settings import BridgeSettings, allows

_OnChange: TypeAlias = Callable[[list[RemoteParameter]], None]

_LONGEST_WAIT_S = 5.0
_EVENTS = "/parameter_events"


class RemoteParameters:
    """Access of Foxglove clients to the parameters of all nodes; used on the server's threads.

    Args:
        node: Node that calls the parameter services of other nodes.
        settings: Settings with the parameters that clients may access.
    """

    def __init__(self, node: Node, settings: BridgeSettings) -> None:
        self._node = node
        self._settings = settings
        self._unresponsive: set[str] = set()
        self._lock = threading.Lock()
        self._watched: set[str] = set()
        self._events: Subscription[Any] | None = None

    def get(self, names: Sequence[str]) -> list[RemoteParameter]:
        """Return allowed parameters by names ``/node.name``; without names, those of all nodes."""
        by_node = _by_node(names) if names else self._all_names()
        own = self._node.get_fully_qualified_name()
        found: list[RemoteParameter] = []
        for node_name in [name for name in by_node if name == own]:
            wanted = by_node.pop(node_name)
            values = self._node.get_parameters([n for n in wanted if self._node.has_parameter(n)])
            found += self._visible(node_name, [(p.name, p.get_parameter_value()) for p in values])
        answers = self._call_nodes(
            by_node, lambda remote: remote.get_parameters(by_node[remote.remote_node_name])
        )
        for node_name, answer in answers.items():
            pairs = list(zip(by_node[node_name], answer.values, strict=False))
            found += self._visible(node_name, pairs)
        return found

    def set(self, parameters: Sequence[RemoteParameter]) -> list[RemoteParameter]:
        """Set allowed parameters of nodes, log refusals, and return the values afterwards."""
        names = [p.name for p in parameters if allows(self._settings.parameters, p.name)]
        types = {p.name: p.type for p in self.get(names)} if names else {}
        by_node: dict[str, list[Parameter]] = {}
        for wanted in parameters:
            node_name, _, name = wanted.name.partition(".")
            if wanted.name in names and name:
                value = _in_type(wanted.get_value(), types.get(wanted.name))
                by_node.setdefault(node_name, []).append(Parameter(name, value=value))
        own = self._node.get_fully_qualified_name()
        if own in by_node:
            self._report(own, self._node.set_parameters(by_node.pop(own)))
        answers = self._call_nodes(
            by_node, lambda remote: remote.set_parameters(by_node[remote.remote_node_name])
        )
        for node_name, answer in answers.items():
            self._report(node_name, answer.results)
        return self.get(names) if names else []

    def watch(self, names: Iterable[str], on_change: _OnChange) -> None:
        """Watch more parameters; the first call's ``on_change`` gets the values of all changes."""
        with self._lock:
            self._watched.update(names)
            if self._events is None:
                self._events = self._node.create_subscription(
                    get_message("rcl_interfaces/msg/ParameterEvent"),
                    _EVENTS,
                    lambda event: self._on_event(event, on_change),
                    qos_profile_parameter_events,
                )

    def unwatch(self, names: Iterable[str]) -> None:
        """Stop reporting changes of the named parameters."""
        with self._lock:
            self._watched.difference_update(names)

    def _on_event(self, event: Any, on_change: _OnChange) -> None:
        changed = [(p.name, p.value) for p in (*event.new_parameters, *event.changed_parameters)]
        with self._lock:
            watched = [pair for pair in changed if f"{event.node}.{pair[0]}" in self._watched]
        visible = self._visible(event.node, watched)
        if visible:
            on_change(visible)

    def _visible(self, node_name: str, pairs: Iterable[tuple[str, Any]]) -> list[RemoteParameter]:
        return [
            _to_remote(f"{node_name}.{name}", value)
            for name, value in pairs
            if allows(self._settings.parameters, f"{node_name}.{name}")
            and value.type != ParameterType.NOT_SET
        ]

    def _all_names(self) -> dict[str, list[str]]:
        graph = self._node.graph()
        own = self._node.get_fully_qualified_name()
        nodes = [
            name
            for name in graph.node_names()
            if name != own and graph.servers(f"{name}/list_parameters")
        ]
        answers = self._call_nodes(dict.fromkeys(nodes), lambda remote: remote.list_parameters())
        found = {name: list(answer.result.names) for name, answer in answers.items()}
        found[own] = self._node.list_parameters([], 0).names
        return found

    def _call_nodes(self, nodes: Iterable[str], question: Any) -> dict[str, Any]:
        if self._settings.ignores_unresponsive:
            nodes = [name for name in nodes if name not in self._unresponsive]
        answers = call_parameter_services(self._node, nodes, question, _LONGEST_WAIT_S)
        found = {}
        for name, answer in answers.items():
            if isinstance(answer, UnavailableError):
                self._unresponsive.add(name)
                self._node.get_logger().warning(answer.message)
            else:
                found[name] = answer
        return found

    def _report(self, node_name: str, results: Iterable[Any]) -> None:
        for result in results:
            if not result.successful:
                self._node.get_logger().warning(f"{node_name} refuses: {result.reason}")


def _by_node(names: Iterable[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for full_name in names:
        node_name, _, name = full_name.partition(".")
        if name:
            found.setdefault(node_name, []).append(name)
    return found


def _to_remote(name: str, message: Any) -> RemoteParameter:
    value: Any = parameter_value_to_python(message)
    kinds = {
        ParameterType.DOUBLE: RemoteType.Float64,
        ParameterType.DOUBLE_ARRAY: RemoteType.Float64Array,
    }
    if message.type == ParameterType.BYTE_ARRAY:
        return RemoteParameter(name, value=b"".join(value))
    return RemoteParameter(name, value=value, type=kinds.get(ParameterType(message.type)))


def _in_type(value: Any, kind: RemoteType | None) -> Any:
    """Convert integers to floats where the parameter has floats: JSON has one number type."""
    if kind == RemoteType.Float64 and isinstance(value, int):
        return float(value)
    if kind == RemoteType.Float64Array and isinstance(value, list):
        return [float(element) for element in value]
    return value
