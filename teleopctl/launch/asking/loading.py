"""Loads components into a container, one after the other."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from teleopctl.launch.asking.asking import CallSequence
from teleopctl.launch.model.action import Launch
from teleopctl.launch.model.plan import ComponentPlan

if TYPE_CHECKING:
    from teleopctl.node import Node

_LOGGER = "launch_ros.actions.load_composable_nodes"

# The last one that loads into a container of a launch, by the container's name.
_turns: WeakKeyDictionary[Launch, dict[str, threading.Event]] = WeakKeyDictionary()


class Loading(CallSequence):
    """Loads components into a container, once that is there.

    Args:
        container: Full name of its node.
        components: The components, in order.
        launch: The launch.

    Attributes:
        components: The components.
    """

    def __init__(self, container: str, components: Sequence[ComponentPlan], launch: Launch) -> None:
        super().__init__(container, launch)
        self.components = tuple(components)
        # What a file says first is loaded first.
        turns = _turns.setdefault(launch, {})
        self._before = turns.get(container)
        self._is_done = turns[container] = threading.Event()

    def describe(self) -> Iterator[str]:
        """Yield the components as command lines, for a dry run."""
        for each in self.components:
            words = [each.package, each.plugin]
            if each.name:
                words += ["-r", f"__node:={each.name}"]
            if each.namespace != "/":
                words += ["-r", f"__ns:={each.namespace}"]
            for file in each.parameter_files:
                words += ["--params-file", file]
            for rule in each.remaps:
                words += ["-r", rule]
            words += [f"{name}:={value}" for name, value in each.extra_arguments]
            then = ", then configured and activated" if each.autostart else ""
            yield f"into {self.node_name}: {' '.join(words)}{then}"

    def ask(self, node: Node) -> None:
        """Load the components, after earlier loads of the container have ended."""
        if self._before is not None:
            self._before.wait()
        from teleopctl.interfaces import get_service

        kind = get_service("composition_interfaces/srv/LoadNode")
        for each in self.components:
            request = _request(kind.Request(), each)
            response = self.call(node, kind, f"{self.node_name}/_container/load_node", request)
            if response.success:
                text = f"Loaded node '{response.full_node_name}' in container '{self.node_name}'"
                self.say("INFO", text, _LOGGER)
                if each.autostart:
                    self.activate(node, response.full_node_name)
            else:
                self.say(
                    "ERROR",
                    f"Failed to load node '{each.name or ''}' of type '{each.plugin}' in container "
                    f"'{self.node_name}': {response.error_message}",
                    _LOGGER,
                )

    def ended(self) -> None:
        """Let the next load request of the container start."""
        self._is_done.set()


# Any: a LoadNode request.
def _request(request: Any, plan: ComponentPlan) -> Any:
    from teleopctl.node import Parameter, read_parameter_file

    # Sections with wildcards count for a node whose name is not known here.
    full_name = f"{plan.namespace.rstrip('/')}/{plan.name or ''}"
    values: dict[str, Any] = {}
    for file in plan.parameter_files:
        values.update(read_parameter_file(Path(file)).for_node(full_name))
    request.package_name = plan.package
    request.plugin_name = plan.plugin
    request.node_name = plan.name or ""
    request.node_namespace = plan.namespace
    request.remap_rules = list(plan.remaps)
    request.parameters = [
        Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
    ]
    extra: dict[str, Any] = dict(plan.extra_arguments)
    request.extra_arguments = [
        Parameter(name, value=value).to_parameter_msg() for name, value in extra.items()
    ]
    return request
