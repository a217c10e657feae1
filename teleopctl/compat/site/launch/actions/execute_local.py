"""``launch.actions.execute_local``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from teleopctl import launch as model
from teleopctl.launch import ProcessExited, ProcessPart, ProcessPlan, ProcessStarted, dataclass

from .._texts import optional, template
from ..action import Action
from ..event import Event
from ..event_handlers.on_action_event_base import OnActionEventBase
from ..events import process as events
from ..events._model import details
from ..events.process import ProcessIO
from ..launch_context import LaunchContext
from ..launch_description_entity import LaunchDescriptionEntity
from ..substitution import Substitution
from ..substitutions.launch_configuration import LaunchConfiguration
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..descriptions import Executable
    from ..event_handlers.on_action_event_base import OnEvent
    from ..some_substitutions_type import SomeSubstitutionsType


_LINE = "[{this.process_description.final_name}] {line}"


class ExecuteLocal(Action):
    """Starts a process.

    Args:
        process_description: The command line; None for a subclass with a `process` of its own.
        shell: Whether a shell reads the command line.
        sigterm_timeout: Seconds from SIGINT to SIGTERM.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL.
        emulate_tty: Whether it is to take its output for a terminal.
        output: ``screen``, ``log``, ``both`` …, or such a word for each of ``stdout`` and
            ``stderr``.
        output_format: Without effect, which is told where it is another one: a line has the
            process's name in front.
        cached_output: Whether to keep the output for `get_stdout` and `get_stderr`.
        log_cmd: Whether to log the command line.
        on_exit: Entities to visit after its exit, or a function that is called with event and
            context and may say so.
        respawn: Whether it is started again when it has ended.
        respawn_delay: Seconds to wait before that.
        respawn_max_retries: Largest number of restarts; negative for no limit.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self,
        *,
        process_description: Executable | None = None,
        shell: bool = False,
        sigterm_timeout: SomeSubstitutionsType | float | None = None,
        sigkill_timeout: SomeSubstitutionsType | float | None = None,
        emulate_tty: bool | SomeSubstitutionsType = False,
        output: SomeSubstitutionsType | Mapping[str, Any] = "log",
        output_format: str = _LINE,
        cached_output: bool = False,
        log_cmd: bool = False,
        on_exit: OnEvent | None = None,
        respawn: bool | SomeSubstitutionsType = False,
        respawn_delay: float | SomeSubstitutionsType | None = None,
        respawn_max_retries: int | SomeSubstitutionsType = -1,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._description = process_description
        self._settings: dict[str, Any] = {
            "shell": optional(shell),
            "sigterm_timeout": optional(sigterm_timeout),
            "sigkill_timeout": optional(sigkill_timeout),
            "output": _output(output),
            "respawn": optional(respawn),
            "respawn_delay": optional(respawn_delay),
            "respawn_max_retries": optional(respawn_max_retries),
            "emulate_tty": optional(emulate_tty) if emulate_tty else None,
            "on_event": self._on_event,
        }
        # The launch has a variable of that name, which `ros2 launch` sets.
        self._sigterm_timeout = _seconds(sigterm_timeout, "sigterm_timeout")
        self._sigkill_timeout = _seconds(sigkill_timeout, "sigkill_timeout")
        self._shell = shell
        self._emulate_tty = emulate_tty
        self._output = output
        self._log_cmd = log_cmd
        self._has_format = output_format != _LINE
        self._on_exit = on_exit
        self._plan: ProcessPlan | None = None
        self._launch: model.Launch | None = None
        self._pid: int | None = None
        self._exit_status: int | None = None
        self._starts = 0
        self._written: dict[str, list[bytes]] | None = None
        if cached_output:
            self._written = {"stdout": [], "stderr": []}

    @property
    def process_description(self) -> Executable | None:
        """The command line, or None."""
        return self._description

    @property
    def shell(self) -> bool:
        """Whether a shell reads the command line."""
        return self._shell

    @property
    def emulate_tty(self) -> bool | SomeSubstitutionsType:
        """Whether the process gets a pseudo-terminal for its output."""
        return self._emulate_tty

    @property
    def output(self) -> SomeSubstitutionsType | Mapping[str, Any]:
        """Destinations of the output."""
        return self._output

    @property
    def sigterm_timeout(self) -> list[Substitution]:
        """Seconds from SIGINT to SIGTERM."""
        return self._sigterm_timeout

    @property
    def sigkill_timeout(self) -> list[Substitution]:
        """Seconds from SIGTERM to SIGKILL."""
        return self._sigkill_timeout

    @property
    def process_details(self) -> dict[str, Any] | None:
        """Fields of the process's events: action, name, cmd, cwd, env, pid; None before start."""
        if self._plan is None:
            return None
        told = details(ProcessPart(origin=self), self._plan, self._pid or 0)
        if self._pid is None:
            del told["pid"]
        return told

    @property
    def return_code(self) -> int | None:
        """Exit status; None before the process has ended."""
        return self._exit_status

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities of ``on_exit``, if it is a list."""
        return self._on_exit if isinstance(self._on_exit, list) else []

    def get_stdout(self) -> str:
        """Return the cached stdout of the process.

        Raises:
            RuntimeError: `cached_output` is false.
        """
        return self._cached("stdout")

    def get_stderr(self) -> str:
        """Return the cached stderr of the process.

        Raises:
            RuntimeError: `cached_output` is false.
        """
        return self._cached("stderr")

    def _cached(self, name: str) -> str:
        if self._written is None:
            called = self._description.name if self._description is not None else None
            raise RuntimeError(
                f"cached output must be true to be able to get {name}, proc '{called}'"
            )
        return b"".join(self._written[name]).decode(errors="replace")

    def prepare(self, context: LaunchContext) -> None:
        """Evaluate the command line, without starting the process."""
        self._plan = context.launch.plan_of(self.process())
        if self._description is not None:
            self._description.planned(self._plan)

    def planned(self, plan: ProcessPlan, launch: model.Launch) -> None:
        """Record the evaluated process, which is about to start.

        Raises:
            RuntimeError: The action has been executed before.
        """
        if self._launch is not None:
            raise RuntimeError(
                f"ExecuteLocal action '{plan.name}': executed more than once: {self.describe()}"
            )
        self._plan, self._launch = plan, launch
        if self._description is not None:
            self._description.planned(plan)
        if self._log_cmd:
            words = " ".join(word for word in plan.command if word.strip())
            about = f"cmd='{words}', cwd='{plan.working_directory}', custom_env?=True"
            launch.log("INFO", f"process details: {about}", plan.name)
        if self._has_format:
            launch.log(
                "WARNING", "output_format is without effect: lines are '[NAME] …'", plan.name
            )
        if self._written is not None:
            self._answer(ProcessIO, lambda event, _: self._keep(event), launch)
        if self._on_exit is not None:
            self._answer(events.ProcessExited, self._on_exit, launch)

    def _answer(self, kind: type[Event], what: OnEvent, launch: model.Launch) -> None:
        """Register a handler for an event type of this process."""
        handler = OnActionEventBase(
            action_matcher=self,
            on_event=what,
            target_event_cls=kind,
            target_action_cls=ExecuteLocal,
        )
        launch.register(handler.model_handler())

    def _keep(self, event: Event) -> None:
        assert self._written is not None
        assert isinstance(event, ProcessIO)
        self._written["stdout" if event.from_stdout else "stderr"].append(event.text)

    # object: an event of the model.
    def _on_event(self, event: object) -> None:
        """Update process id, exit status and number of starts from an event."""
        if isinstance(event, ProcessStarted):
            self._pid = event.pid
            self._exit_status = None
            self._starts += 1
        elif isinstance(event, ProcessExited) and self._launch is not None:
            self._exit_status = event.exit_status
            retries = event.plan.respawn_max_retries
            ends = not event.plan.respawn or 0 <= retries < self._starts
            if ends or self._launch.is_ending:
                self.tell_completion(LaunchContext.with_launch(self._launch))

    def done(self, context: LaunchContext) -> None:
        """Do nothing: the exit of the process completes the action."""

    def process(self) -> ProcessPart:
        """Return the process as one of `teleopctl.launch`.

        Raises:
            TypeError: There is no description.
        """
        if self._description is None:
            raise TypeError(f"{type(self).__name__}: 'process_description' is missing")
        return self._description.process(origin=self, **self._settings)

    def model_action(self) -> model.Action:
        """Return the corresponding action of `teleopctl.launch`."""
        return _Start(self)


def _output(output: SomeSubstitutionsType | Mapping[str, Any]) -> Any:
    if not isinstance(output, Mapping):
        return optional(output)
    return {
        source: tuple(map(template, [places] if isinstance(places, str) else places))
        for source, places in output.items()
    }


@dataclass(frozen=True, slots=True)
class _Start(model.Action):
    """Action of `teleopctl.launch` that starts the process of an `ExecuteLocal`."""

    entity: ExecuteLocal

    def evaluate(self, launch: model.Launch) -> None:
        """Start the process."""
        plan = launch.start(self.entity.process())
        if not launch.is_trial:
            self.entity.planned(plan, launch)


def _seconds(given: SomeSubstitutionsType | float | None, variable: str) -> list[Substitution]:
    if given is None:
        return [LaunchConfiguration(variable, default="5")]
    return normalize_to_list_of_substitutions(
        str(given) if isinstance(given, float | int) else given
    )
