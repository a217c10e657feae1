"""``launch_ros.actions.node``."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from launch._texts import optional, template
from launch.actions import ExecuteProcess
from launch.launch_context import LaunchContext

from teleopctl.launch import Launch, Node as ModelNode, NodePart, ProcessPart, ProcessPlan

from .._parameters import parameters as model_parameters
from ..utilities import normalize_parameters, normalize_remap_rules

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType

    from ..parameters_type import Parameters, SomeParameters
    from ..remap_rule_type import RemapRule, SomeRemapRules

# The spellings of ROS 2 before Foxy.
_OLD_NAMES = {
    "node_executable": "executable",
    "node_name": "name",
    "node_namespace": "namespace",
}


class Node(ExecuteProcess):
    """Starts an executable of a package as a ROS node.

    Args:
        executable: The program's name, or without a package the command to start.
        package: The package that offers it.
        name: The node's name in place of that in the source.
        namespace: The node's namespace, below the pushed ones.
        exec_name: Its name in the output in place of the program's.
        parameters: Files, and mappings from names to values, in order.
        remappings: Pairs from, to.
        ros_arguments: Further arguments behind ``--ros-args``.
        arguments: Arguments of the program.
        kwargs: Further arguments of `ExecuteProcess`.

    Raises:
        TypeError: There is no executable, or a parameter is none.
    """

    UNSPECIFIED_NODE_NAME = "<node_name_unspecified>"
    UNSPECIFIED_NODE_NAMESPACE = "<node_namespace_unspecified>"

    # Any: arguments of `ExecuteProcess`.
    def __init__(
        self,
        *,
        executable: SomeSubstitutionsType | None = None,
        package: SomeSubstitutionsType | None = None,
        name: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        exec_name: SomeSubstitutionsType | None = None,
        parameters: SomeParameters | None = None,
        remappings: SomeRemapRules | None = None,
        ros_arguments: Iterable[SomeSubstitutionsType] | None = None,
        arguments: Iterable[SomeSubstitutionsType] | None = None,
        **kwargs: Any,
    ) -> None:
        old = {new: kwargs.pop(old) for old, new in _OLD_NAMES.items() if _warned(old, kwargs)}
        executable = old.get("executable", executable)
        if executable is None:
            raise TypeError("Node: the keyword argument 'executable' is missing")
        super().__init__(cmd=[], name=exec_name, **kwargs)
        self._node_name = optional(old.get("name", name))
        self._node_namespace = optional(old.get("namespace", namespace))
        self._given: dict[str, Any] = {
            "package": package,
            "executable": executable,
            "name": old.get("name", name),
            "namespace": old.get("namespace", namespace),
            "parameters": parameters or [],
            "remappings": list(remappings or ()),
            "arguments": arguments,
        }
        self._part = NodePart(
            package=optional(package),
            executable=template(executable),
            name=self._node_name,
            namespace=self._node_namespace,
            parameters=tuple(model_parameters(parameters or [])),
            remaps=tuple(
                (template(source), template(target))
                for source, target in normalize_remap_rules(self._given["remappings"])
            ),
            ros_arguments=_words(ros_arguments),
        )
        self._arguments = _words(arguments)
        self._has_namespace = False
        # Once it is evaluated: its command line, or what ROS 2 adds to it, and its full name.
        self._words: list[str] | None = None
        self._full_name: str | None = None

    @property
    def node_package(self) -> Any:
        """Package of the executable, or None."""
        return self._part.package

    @property
    def node_executable(self) -> Any:
        """Name of the executable."""
        return self._part.executable

    @property
    def node_name(self) -> str:
        """Full name of the node; ``<node_name_unspecified>`` and the like for unknown parts.

        Raises:
            RuntimeError: It has not been evaluated yet.
        """
        if self._words is None:
            raise RuntimeError("cannot access 'node_name' before executing action")
        if self._full_name is not None and self._has_namespace:
            return self._full_name
        return f"{self.expanded_node_namespace.rstrip('/')}/{self.__expanded_node_name}"

    @property
    def expanded_node_namespace(self) -> str:
        """Namespace after evaluation; in angle brackets if it is not given."""
        if not self._has_namespace:
            return self.UNSPECIFIED_NODE_NAMESPACE
        return dict(self._rules()).get("__ns", "/")

    @property
    def expanded_remapping_rules(self) -> list[tuple[str, str]] | None:
        """Remappings after evaluation, global ones first; None for none."""
        return [rule for rule in self._rules() if not rule[0].startswith("__")] or None

    def _rules(self) -> list[tuple[str, str]]:
        rules = [rule for word, rule in itertools.pairwise(self._words or ()) if word == "-r"]
        return [(source, target) for source, _, target in (rule.partition(":=") for rule in rules)]

    def is_node_name_fully_specified(self) -> bool:
        """Return whether name and namespace are given."""
        return self._full_name is not None and self._has_namespace

    def planned(self, plan: ProcessPlan, launch: Launch) -> None:
        """Record the evaluated process, which is about to start."""
        self._record(plan.command, plan.node_name, launch)
        super().planned(plan, launch)

    def _record(self, words: list[str], full_name: str | None, launch: Launch) -> None:
        self._words, self._full_name = words, full_name
        self._has_namespace = self._node_namespace is not None or launch.scope.has_namespace

    # The names below are private in ROS 2's class of the same name. Subclasses call the method
    # before they look at `node_name`, and tests of launch files read the others.
    def _perform_substitutions(self, context: LaunchContext) -> None:
        """Evaluate name, namespace, parameters and remappings; nothing is started."""
        with LaunchContext.standing_for(context) as known:
            self._record(*known.launch.ros_arguments_of(self._part), known.launch)

    # Any: what was given.
    @property
    def __package(self) -> Any:
        return self._given["package"]

    @property
    def __node_executable(self) -> Any:
        return self._given["executable"]

    @property
    def __node_name(self) -> Any:
        return self._given["name"]

    @property
    def __node_namespace(self) -> Any:
        return self._given["namespace"]

    @property
    def __arguments(self) -> Any:
        return self._given["arguments"]

    @property
    def __parameters(self) -> Parameters:
        return normalize_parameters(self._given["parameters"])

    @property
    def __remappings(self) -> list[RemapRule]:
        return list(normalize_remap_rules(self._given["remappings"]))

    @property
    def __expanded_node_name(self) -> str:
        return (self._full_name or self.UNSPECIFIED_NODE_NAME).rpartition("/")[2]

    @property
    def __expanded_node_namespace(self) -> str:
        return self.expanded_node_namespace

    @property
    def __expanded_remappings(self) -> list[tuple[str, str]] | None:
        return self.expanded_remapping_rules

    @property
    def __expanded_parameter_arguments(self) -> list[tuple[str, bool]] | None:
        words = itertools.pairwise(self._words or ())
        files = [(file, True) for word, file in words if word == "--params-file"]
        return files or None

    def describe(self) -> str:
        """Return a readable form of the action."""
        package = f"{self._part.package.source} " if self._part.package is not None else ""
        return f"{type(self).__name__}({package}{self._part.executable.source})"

    def process(self) -> ProcessPart:
        """Return the process as one of `teleopctl.launch`."""
        return ModelNode(node=self._part, arguments=self._arguments, origin=self, **self._settings)


def _warned(old: str, kwargs: dict[str, Any]) -> bool:
    if old not in kwargs:
        return False
    warnings.warn(
        f"The parameter '{old}' is deprecated, use '{_OLD_NAMES[old]}' instead", stacklevel=4
    )
    return True


def _words(given: Iterable[SomeSubstitutionsType] | None) -> Any:
    return None if given is None else tuple(map(template, given))
