"""State of a launch's evaluation: launch configurations, environment, namespace, current file."""

from __future__ import annotations

import os
import re
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

from teleopctl.base.budget import MOST_INCLUDED_FILES, MOST_LAUNCH_TEXT, BudgetError, Tally
from teleopctl.base.typed import TYPE_CHECKING, Collection, Iterator, Mapping, NamedTuple
from teleopctl.errors import InvalidDescriptionError, LaunchError, TeleopctlError
from teleopctl.launch.model.action import Launch
from teleopctl.launch.model.descriptions import Place
from teleopctl.launch.model.scope import Scope
from teleopctl.launch.model.template import Template

if TYPE_CHECKING:
    from teleopctl.robot import ExpandedXacro

# Tags that only MoveIt's semantic description (SRDF) has; its root tag is ``robot``, too.
_SEMANTIC = re.compile("<(?:group|group_state|end_effector|virtual_joint|disable_collisions)[ />]")


class EvaluationPoint(NamedTuple):
    """Scope and launch file at one point of a launch's evaluation, to continue from there later.

    Attributes:
        scope: Launch configurations, environment, namespace and so on; not a copy, so that later
            changes to the scope are included.
        file: Path of the launch file.
    """

    scope: Scope
    file: Path


class LaunchContext:
    """State that substitutions of launch files are evaluated with: scope, current file, ROS graph.

    Args:
        arguments: Launch arguments from the command line.
        log_directory: Log folder of the launch.

    Attributes:
        arguments: Launch arguments from the command line.
        declared: Names of the launch arguments that were declared by a launch file, or by a robot
            description to which they were passed.
        node_names: Number of nodes with each full name, as far as the launch file gives names.
        uses_sim_time: Whether timers of ROS time follow ``/clock``.
        event: Event that is being handled; None during the evaluation of the launch files.
        launch: Evaluation that this context belongs to; None before the evaluation is created.
        shown_as: Object with which the Python front end represents this context; None until then.
        characters: Number of characters evaluated for the start, or for one event.
        included: Number of files included for the start, or for one event.
    """

    def __init__(self, arguments: Mapping[str, str], log_directory: Path) -> None:
        self.scope = Scope(variables=dict(arguments))
        self.arguments = dict(arguments)
        self.log_directory = log_directory
        self.event: object | None = None
        self.launch: Launch | None = None
        self.shown_as: object | None = None
        self.characters = Tally("characters in all", MOST_LAUNCH_TEXT)
        self.included = Tally("included files", MOST_INCLUDED_FILES)
        self.declared: set[str] = set()
        self._declared_in: dict[Path, set[str]] = {}
        self.node_names: Counter[str] = Counter()
        self.uses_sim_time = False
        self.file = Path()
        self.warnings: list[str] = []
        self._live_nodes: frozenset[str] | None = None
        self._robots: dict[tuple[str, tuple[tuple[str, str], ...]], ExpandedXacro] = {}
        self._anonymous: dict[str, str] = {}

    def copy(self) -> LaunchContext:
        """Return a copy whose scope and node names change independently, for a dry run."""
        import copy

        other = copy.copy(self)
        other.scope = self.scope.copy()
        other.declared = set(self.declared)
        other.node_names = self.node_names.copy()
        other.warnings = []
        other.launch = other.shown_as = None
        return other

    @contextmanager
    def scoped(self) -> Iterator[None]:
        """Restore the scope (configurations, environment …) at the end of the ``with`` block."""
        outer = self.scope
        self.scope = outer.copy()
        try:
            yield
        finally:
            self.scope = outer

    @contextmanager
    def inside(self, file: Path) -> Iterator[None]:
        """Make a launch file the current one within the ``with`` block."""
        outer, self.file = self.file, file
        try:
            yield
        finally:
            self.file = outer

    def moment(self) -> EvaluationPoint:
        """Return the present scope (itself, no copy) and launch file, which `at` can use later."""
        return EvaluationPoint(self.scope, self.file)

    @contextmanager
    def at(self, moment: EvaluationPoint) -> Iterator[None]:
        """Use the scope and launch file of an earlier point within the ``with`` block."""
        outer = self.moment()
        self.scope, self.file = moment
        try:
            yield
        finally:
            self.scope, self.file = outer

    @contextmanager
    def answering(self, event: object) -> Iterator[None]:
        """Set the event that substitutions can read, within the ``with`` block."""
        outer, self.event = self.event, event
        try:
            yield
        finally:
            self.event = outer

    @contextmanager
    def reading(self, text: Template) -> Iterator[None]:
        """Prefix errors in the ``with`` block with NAME if the text is just ``$(var NAME)``."""
        try:
            yield
        except TeleopctlError as error:
            name = text.variable
            if name is None:
                raise
            kind = "argument" if name in self.declared else "configuration"
            message = f"launch {kind} '{name}': {error.message}"
            raise LaunchError(message, hint=error.hint) from error

    def environment(self) -> dict[str, str]:
        """Return all environment variables for a process that is started at this point."""
        merged = {**os.environ, **self.scope.environment}
        return {name: value for name, value in merged.items() if value is not None}

    def environment_value(self, name: str) -> str | None:
        """Return an environment variable's value for processes started now; None if unset."""
        if name in self.scope.environment:
            return self.scope.environment[name]
        return os.environ.get(name)  # ignores letter case on Windows

    def count_included(self) -> None:
        """Count one more included launch file; raise if the launch includes too many.

        Raises:
            LaunchError: Too many files are included, such as files that include each other twice.
        """
        try:
            self.included.add()
        except BudgetError as error:
            raise LaunchError(f"the launch takes {error}") from error

    def declare(self, name: str) -> None:
        """Record an argument as declared by the current launch file, not to be passed to xacro."""
        self.declared.add(name)
        self._declared_in.setdefault(self.file, set()).add(name)

    def forwarded_arguments(self) -> dict[str, str]:
        """Return given launch arguments that the current file does not declare, values by name."""
        given = self.scope.given | self.arguments.keys()
        return {
            name: self.scope.variables[name]
            for name in sorted(given - self._declared_in.get(self.file, set()))
            if name in self.scope.variables
        }

    def robot_description(self, file: Path, mappings: Mapping[str, str]) -> str:
        """Return the URDF text of a description file, expanded with xacro arguments; cached.

        Raises:
            TeleopctlError: The file is missing, does not parse, or describes no robot.
        """
        return self._expanded(file, mappings).text

    def arguments_for_robot(self, file: Path, mappings: Mapping[str, str]) -> dict[str, str]:
        """Return launch arguments that only the xacro file declares, and count them as declared.

        Args:
            file: Path of the xacro file.
            mappings: Xacro arguments that the launch file passes; they are left out of the result.

        Raises:
            TeleopctlError: Same as for `robot_description`.
        """
        from teleopctl.robot import xacro_arguments

        forwarded_arguments = {
            name: value
            for name, value in self.forwarded_arguments().items()
            if name not in mappings
        }
        if not forwarded_arguments or self._takes_none(file, mappings, forwarded_arguments):
            return {}
        taken = xacro_arguments(self._expanded(file, {**forwarded_arguments, **mappings}).files)
        given = {name: value for name, value in forwarded_arguments.items() if name in taken}
        self.declared.update(given)
        return given

    def _takes_none(self, file: Path, mappings: Mapping[str, str], names: Collection[str]) -> bool:
        """Return whether a description, expanded without arguments of these names, has none.

        That expansion is needed anyway then, and not another one with the other arguments.
        """
        from teleopctl.robot import xacro_arguments

        if not xacro_arguments([file]).keys().isdisjoint(names):
            return False
        try:
            return xacro_arguments(self._expanded(file, mappings).files).keys().isdisjoint(names)
        except TeleopctlError:
            return False  # an argument may be required

    def _expanded(self, file: Path, mappings: Mapping[str, str]) -> ExpandedXacro:
        key = (str(file), tuple(sorted(mappings.items())))
        if key not in self._robots:
            self._robots[key] = _read_robot(file, mappings)
        return self._robots[key]

    def files_of_robot(self, file: Path, mappings: Mapping[str, str]) -> tuple[Path, ...]:
        """Return the paths of a robot description file and of all files that it includes.

        Raises:
            TeleopctlError: Same as for `robot_description`.
        """
        return self._expanded(file, mappings).files

    def node_is_running(self, name: str) -> bool:
        """Return whether a node with a full name is in the ROS graph; the graph is queried once."""
        if self._live_nodes is None:
            self._live_nodes = _query_nodes()
        return name in self._live_nodes

    def copy_names(self, other: LaunchContext) -> None:
        """Take over the anonymous names and the known running nodes of another context."""
        self._anonymous = other._anonymous
        self._live_nodes = other._live_nodes

    def anonymous_name(self, name: str) -> str:
        """Return the unique name that ``$(anon NAME)`` stands for in this launch."""
        if name not in self._anonymous:
            import random
            import socket

            unique = f"{socket.gethostname()}_{os.getpid()}_{random.getrandbits(63)}"
            self._anonymous[name] = re.sub("[.:-]", "_", f"{name}_{unique}")
        return self._anonymous[name]


@contextmanager
def with_location(place: Place) -> Iterator[None]:
    """Prefix errors in the ``with`` block with file and line, unless they have a place already."""
    try:
        yield
    except TeleopctlError as error:
        if error.place is not None:
            raise
        raise error.at(str(place)) from error


def _read_robot(file: Path, mappings: Mapping[str, str]) -> ExpandedXacro:
    from teleopctl.robot import RobotDescription, read_model

    try:
        expanded = read_model(file, dict(mappings))
    except InvalidDescriptionError as error:
        # The message names the faulty file, which is not the launch file.
        error.place = str(file)
        raise
    text = expanded.text
    if "<robot" in text and not _SEMANTIC.search(text):
        # An error is reported here, once, instead of by each node that reads the description.
        try:
            RobotDescription.from_urdf(text)
        except TeleopctlError as error:
            raise error.at(str(file)) from error
    return expanded


def _query_nodes() -> frozenset[str]:
    from teleopctl.wire import RouterNotRunning, close_session, open_session, query_graph

    try:
        session = open_session("client")
    except RouterNotRunning:
        return frozenset()  # nodes discover each other through the router
    try:
        return frozenset(query_graph(session).node_names(include_hidden=True))
    finally:
        close_session(session)
