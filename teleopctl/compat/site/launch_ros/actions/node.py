"""``launch_ros.actions.node``."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from launch._texts import optional, template
from launch.actions import ExecuteProcess

from teleopctl.launch import Launch, Node as ModelNode, NodePart, ProcessPart, ProcessPlan

from .._parameters import parameters as model_parameters
from ..utilities import normalize_remap_rules

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType

    from ..parameters_type import SomeParameters
    from ..remap_rule_type import SomeRemapRules

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
        kwargs: What `ExecuteProcess` takes.

    Raises:
        TypeError: There is no executable, or a parameter is none.
    """

    UNSPECIFIED_NODE_NAME = "<node_name_unspecified>"
    UNSPECIFIED_NODE_NAMESPACE = "<node_namespace_unspecified>"

    # Any: the words of ExecuteProcess.
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
        self._part = NodePart(
            package=optional(package),
            executable=template(executable),
            name=self._node_name,
            namespace=self._node_namespace,
            parameters=tuple(model_parameters(parameters or [])),
            remaps=tuple(
                (template(source), template(target))
                for source, target in normalize_remap_rules(remappings or ())
            ),
            ros_arguments=_words(ros_arguments),
        )
        self._arguments = _words(arguments)
        self._has_namespace = False

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
        if self._plan is None:
            raise RuntimeError("cannot access 'node_name' before executing action")
        if self._plan.node_name is not None and self._has_namespace:
            return self._plan.node_name
        name = (self._plan.node_name or self.UNSPECIFIED_NODE_NAME).rpartition("/")[2]
        return f"{self.expanded_node_namespace.rstrip('/')}/{name}"

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
        words = self._plan.command if self._plan is not None else []
        rules = [rule for word, rule in itertools.pairwise(words) if word == "-r"]
        return [(source, target) for source, _, target in (rule.partition(":=") for rule in rules)]

    def is_node_name_fully_specified(self) -> bool:
        """Return whether name and namespace are given."""
        return self._plan is not None and self._plan.node_name is not None and self._has_namespace

    def planned(self, plan: ProcessPlan, launch: Launch) -> None:
        """Record the evaluated process, which is about to start."""
        self._has_namespace = self._node_namespace is not None or launch.scope.has_namespace
        super().planned(plan, launch)

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
