"""Base class of launch actions, and interfaces of the launch and of event handlers for them."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from types import MappingProxyType

from teleopctl import plugins
from teleopctl.base.typed import Callable, ClassVar, Iterable, Mapping, Protocol, Self
from teleopctl.errors import did_you_mean
from teleopctl.launch.model.descriptions import ComponentPart, Condition, Place, ProcessPart
from teleopctl.launch.model.element import Element
from teleopctl.launch.model.plan import ComponentPlan, ProcessPlan, Work
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.scope import Scope
from teleopctl.launch.model.template import Call, Template

_NO_NAMES: Mapping[str, str] = MappingProxyType({})


class Entity:
    """Entry of an XML or YAML launch file, by key; keys outside ``known`` raise errors.

    A key is an attribute or nested tag in XML, and a key of a mapping in YAML.

    Args:
        element: Content of the entry: a mapping in YAML, the action's tag in XML.
        known: Keys that the entry may have, with hyphens or with underscores.
        read_steps: Function that reads a list of actions; None if the entry has no actions.
        renamed: Keys by their names in ROS 1, older ROS 2 or Python launch files, for messages.

    Raises:
        TeleopctlError: The element has no keys, or has an unknown key.
    """

    def __init__(
        self,
        element: Element,
        known: Iterable[str],
        read_steps: Callable[[Element], tuple[Step, ...]] | None = None,
        renamed: Mapping[str, str] = _NO_NAMES,
    ) -> None:
        self._element = element
        self._read_steps = read_steps
        self._fields: dict[str, Element] = {}
        keys = tuple(known)
        canonical = {key.replace("-", "_"): key for key in keys}
        for key, value in element.fields(keys).items():
            plain = key.replace("-", "_")
            name = canonical.get(plain)
            if name is None:
                raise value.error(
                    f"unknown {value.noun} '{key}', expected one of {', '.join(keys)}",
                    hint=f"In ROS 2: '{renamed[plain]}'."
                    if plain in renamed
                    else did_you_mean(key, keys),
                )
            self._fields[name] = value

    def element(self, key: str) -> Element | None:
        """Return a key's value as an element with file and line; None if the key is missing."""
        return self._fields.get(key)

    def required_element(self, key: str) -> Element:
        """Return a key's value as an element with file and line; raise if the key is missing.

        Raises:
            TeleopctlError: The key is missing.
        """
        if key not in self._fields:
            raise self._element.error(f"'{key}' is missing")
        return self._fields[key]

    def required(self, key: str) -> Template:
        """Return a key's text as a template with substitutions; raise if the key is missing."""
        return self.required_element(key).template()

    def required_text(self, key: str) -> str:
        """Return a key's text as written, where substitutions are not allowed; raise if missing."""
        return self.required_element(key).text()

    def optional(self, key: str) -> Template | None:
        """Return a key's text as a template with substitutions; None if the key is missing."""
        element = self._fields.get(key)
        return None if element is None else element.template()

    def pairs(self, key: str, first: str, second: str) -> tuple[tuple[Template, Template], ...]:
        """Return the ``first`` and ``second`` texts of each mapping in a key's list, if any."""
        element = self._fields.get(key)
        if element is None:
            return ()
        entities = (
            Entity(item, (first, second))
            for item in element.items(f"a list of mappings with '{first}' and '{second}'")
        )
        return tuple((entity.required(first), entity.required(second)) for entity in entities)

    def conditions(self) -> tuple[Condition, ...]:
        """Return the entry's conditions ``if`` and ``unless``."""
        return tuple(
            Condition(text, expected)
            for key, expected in (("if", True), ("unless", False))
            if (text := self.optional(key)) is not None
        )

    def steps(self, key: str) -> tuple[Step, ...]:
        """Return the actions listed below a key, as steps; raise if the key is missing."""
        assert self._read_steps is not None
        return self._read_steps(self.required_element(key))


class Action:
    """Base of launch actions: one subclass for each kind of entry in launch files.

    An action is plain data with unevaluated texts. XML and YAML front ends create an action by
    `parse`, a Python launch file by the constructor; `evaluate` does not depend on the front end.

    Attributes:
        keys: Keys that the entry may have in a launch file, apart from ``if`` and ``unless``.
        renamed: Keys by their names in ROS 1, older ROS 2 or Python launch files, with underscores.
    """

    __slots__ = ()
    keys: ClassVar[tuple[str, ...]] = ()
    renamed: ClassVar[Mapping[str, str]] = _NO_NAMES

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an entry of a launch file describes.

        Raises:
            LaunchError: A key is missing, or a value is invalid; the methods of `entity` raise such
                errors with file and line.
        """
        raise NotImplementedError

    def evaluate(self, launch: Launch) -> Iterable[Action] | None:
        """Execute the action: change scope, add processes, run steps; return more actions or None.

        The actions that it returns are evaluated after this one.

        Raises:
            TeleopctlError: The action fails; the caller puts file and line before the message.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Step:
    """A launch action with its conditions and its place in a launch file.

    Attributes:
        place: File and line of the entry.
        conditions: Conditions that all have to hold.
        action: Action to evaluate then.
        done: Called with the launch after the action was evaluated, or None.
    """

    place: Place
    conditions: tuple[Condition, ...]
    action: Action
    done: Callable[[Launch], None] | None = None


@dataclass(frozen=True, slots=True)
class LaunchFile:
    """A parsed launch file: its path and steps.

    Attributes:
        path: Path of the launch file.
        steps: Entries of the file, in order.
    """

    path: Path
    steps: tuple[Step, ...]


class Launch(Protocol):
    """Interface of the evaluation of a launch, for actions and event handlers."""

    @property
    def scope(self) -> Scope:
        """Launch configurations, environment, namespace and so on for the next action."""

    @property
    def file(self) -> Path:
        """The launch file that is being evaluated."""

    @property
    def uses_sim_time(self) -> bool:
        """Whether timers of ROS time follow ``/clock``; holds for the whole launch, as in ROS 2."""

    @uses_sim_time.setter
    def uses_sim_time(self, value: bool) -> None: ...

    @property
    def is_trial(self) -> bool:
        """Whether this is a dry run, which must have no effects outside the evaluation."""

    @property
    def is_ending(self) -> bool:
        """Whether the launch shuts down, so that nothing is started any more."""

    @property
    def event(self) -> object | None:
        """The event whose handlers run; None otherwise, such as before the start or in a timer."""

    def text(self, text: Template) -> str:
        """Return the text of a template with all substitutions evaluated."""

    def environment_value(self, name: str) -> str | None:
        """Return an environment variable's value for processes started now; None if unset."""

    def run(self, steps: tuple[Step, ...]) -> None:
        """Evaluate steps in order, skipping those whose conditions do not hold."""

    def run_action(self, action: Action) -> None:
        """Evaluate an action and the actions that it returns; errors get no file and line here."""

    def scoped(self) -> AbstractContextManager[None]:
        """Restore the scope (configurations, environment …) at the end of the ``with`` block."""

    def include(self, path: Path) -> None:
        """Read and evaluate another launch file."""

    def declare(self, name: str) -> None:
        """Record an argument as declared by the current launch file, not to be passed to xacro."""

    def log(self, level: str, message: str, logger: str = "launch.user") -> None:
        """Queue a log line with level and logger name, written after the present evaluation."""

    def start(self, process: ProcessPart) -> ProcessPlan:
        """Return a ``node`` or ``executable``'s plan; its process starts after the evaluation."""

    def component(self, part: ComponentPart) -> ComponentPlan:
        """Return the plan for loading a component, evaluated from its description."""

    def count_node(self, full_name: str, logger: str) -> None:
        """Count a node of the launch by its full name; warn if there is another one."""

    def plan_of_node(self, full_name: str) -> ProcessPlan | None:
        """Return the plan of the process that runs a node, by the node's full name; or None."""

    def action_of(self, plan: ProcessPlan) -> ProcessPart:
        """Return the ``node`` or ``executable`` action that a process plan was made from."""

    def after(
        self,
        seconds: float,
        steps: tuple[Step, ...],
        is_cancelled: Callable[[], bool] = bool,
        *,
        outlives_shutdown: bool = False,
    ) -> None:
        """Add a timer that runs steps after a delay in a copy of the scope, unless cancelled."""

    def decide_last(self, decide: Callable[[], None]) -> None:
        """Call a function in a copy of the present scope, once all steps have been evaluated."""

    def work(self, work: Work) -> None:
        """Add background work, such as service calls; the launch starts and awaits the work."""

    def register(self, handler: Handler, *, last: bool = False) -> None:
        """Register an event handler with the present scope: called first, or last if ``last``."""

    def unregister(self, handler: Handler) -> None:
        """Unregister an event handler; raise ValueError if it is not registered.

        Raises:
            ValueError: The handler is not registered.
        """

    def has_handler_for(self, event: object) -> bool:
        """Return whether any registered handler would respond to an event."""

    def emit(self, event: object) -> None:
        """Queue an event for the registered handlers; any thread may call this."""

    def shut_down(self, reason: str) -> None:
        """Request the shutdown of the launch, with a reason; any thread may call this."""


class Handler(Protocol):
    """Interface of event handlers of a launch.

    Attributes:
        wants_output: Whether the handler takes output events of processes.
    """

    @property
    def wants_output(self) -> bool:
        """Whether the handler takes output events of processes."""

    def dry_run(self) -> tuple[str, tuple[Step, ...]] | None:
        """Return in words when the handler acts, with its steps, for a dry run; None if unknown."""

    def answers(self, event: object, launch: Launch) -> bool:
        """Return whether the handler responds to an event."""

    def respond(self, event: object, launch: Launch) -> Iterable[Step]:
        """Handle a launch event; return the steps to run, none if the handler ignores the event."""


exposed_actions: dict[str, Callable[[str, Element], Step]] = {}
"""Functions of launch extensions that read an action, by the action's name."""

exposed_substitutions: dict[str, Callable[[Call], Template]] = {}
"""Functions of launch extensions that make a template from a call, by substitution name."""


@cache
def load_launch_extensions() -> None:
    """Load the launch extensions of installed distributions, once per process.

    The search takes tens of milliseconds; call this only for a name that is unknown otherwise.
    """
    plugins.import_object(plugins.LAUNCH_EXTENSIONS)()
