"""Evaluation of a launch file and its arguments: the steps at the start, and those on each event.

The whole file is evaluated before the first process starts, as in ROS 2. So nearly all errors are
reported then: unknown packages, missing arguments, robot descriptions that do not parse. Steps that
wait for an event or a timer are evaluated when the event happens or the timer fires, with the
launch configurations of the point at which they were registered.
"""

from __future__ import annotations

import functools
import itertools
import threading
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from teleopctl.base.budget import (
    DEEPEST_FORESIGHT,
    DEEPEST_INCLUDES,
    MOST_STEPS,
    BudgetError,
    Tally,
)
from teleopctl.base.typed import Callable, Collection, Iterable, Iterator, Mapping, NamedTuple
from teleopctl.errors import LaunchError, NotFoundError, TeleopctlError, did_you_mean
from teleopctl.launch.evaluation.context import EvaluationPoint, LaunchContext, with_location
from teleopctl.launch.evaluation.environment import EnvironmentOverlay
from teleopctl.launch.evaluation.processes import ProcessBuilder
from teleopctl.launch.evaluation.substitution import evaluated_text
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Handler, LaunchFile, Step
from teleopctl.launch.model.descriptions import (
    ComponentPart,
    Condition,
    NodePart,
    ProcessPart,
)
from teleopctl.launch.model.events import (
    ProcessEvent,
    ProcessOutput,
    ProcessStarted,
    ShutdownBegan,
    ShutdownRequested,
    SignalRequested,
)
from teleopctl.launch.model.plan import (
    ComponentPlan,
    FollowUp,
    LaunchPlan,
    LaunchTimer,
    ProcessPlan,
    Work,
)
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.launch.model.scope import Scope
from teleopctl.launch.model.template import Template


class DryRun(NamedTuple):
    """Result of evaluating in advance what a timer or an event will lead to.

    Attributes:
        when: Text that describes the event.
        follow_up: Steps that follow the event.
        error: Error that ended the dry run, or None.
        then: Dry runs of the timers and handlers that these steps add.
    """

    when: str
    follow_up: FollowUp
    error: TeleopctlError | None
    then: tuple[DryRun, ...]


def missing_resources(dry_run: Iterable[DryRun]) -> Iterator[TeleopctlError]:
    """Yield the errors about missing packages, programs and files in dry runs.

    Other errors are left out: they may not occur when the event really happens.
    """
    for each in dry_run:
        if isinstance(each.error, NotFoundError):
            yield each.error
        yield from missing_resources(each.then)


def undeclared(arguments: Iterable[str], declared: Collection[str]) -> list[str]:
    """Return a warning text for each given launch argument that is not in ``declared``."""
    known = ", ".join(sorted(declared)) or "none"
    return [
        f"launch argument '{name}' is not declared by the launch file (declared: {known})"
        + (f". {guess}" if (guess := did_you_mean(name, declared)) else "")
        for name in arguments
        if name not in declared
    ]


def evaluate(
    file: LaunchFile,
    arguments: Mapping[str, str],
    log_directory: Path,
    request: LaunchRequest | None = None,
    *,
    again: Evaluation | None = None,
    is_shown: bool = False,
) -> tuple[LaunchPlan, Evaluation]:
    """Evaluate a launch file; return the plan of its first steps, and an `Evaluation` for events.

    Args:
        file: Parsed launch file.
        arguments: Launch arguments by name.
        log_directory: Folder for logs and parameter files of the launch.
        request: Options of the launch; by default those of a new `LaunchRequest`.
        again: Earlier evaluation of the file, whose processes run. The new evaluation then has no
            effects outside.
        is_shown: Whether the plan is only shown, so that a shutdown before the start is no error.

    Raises:
        TeleopctlError: Part of the file cannot be evaluated; the message has file and line.
    """
    context = LaunchContext(arguments, log_directory)
    request = request or LaunchRequest(file=str(file.path))
    evaluation = Evaluation(context, ProcessBuilder(context, request))
    evaluation.skips_missing = request.skip_missing
    if again is not None:
        evaluation.is_trial = True
        context.copy_names(again.context)
    evaluation.run_file(file)
    start = evaluation.take_follow_up()
    if start.shutdown is not None and not is_shown:
        raise shutdown_before_start(start.shutdown)
    for fault in missing_resources(evaluation.dry_run(start)):
        raise fault
    unknown = undeclared(arguments, context.declared)
    warnings = [*context.warnings, *unknown]
    return LaunchPlan(log_directory=log_directory, start=start, warnings=warnings), evaluation


def shutdown_before_start(reason: str, hint: str | None = None) -> LaunchError:
    """Return the error for a launch that its own file shuts down before anything has started."""
    error = LaunchError(reason, hint=hint)
    # The reason from the launch file is more useful than its line number.
    error.place = ""
    return error


class _Registered(NamedTuple):
    """An event handler, and the point of the evaluation at which it was registered."""

    handler: Handler
    moment: EvaluationPoint


# Of the parameter files that `Evaluation.ros_arguments_of` writes.
_numbers = itertools.count(1)


@functools.cache
def _folder_without_launch() -> Path:
    """Return the folder of these files for contexts without a launch; it is removed at exit."""
    import atexit

    from teleopctl.base import background

    folder = background.temporary_folder()
    atexit.register(folder.remove)
    return folder.path


class TimedSteps(NamedTuple):
    """Steps that a launch timer runs when it fires, with scope and file to evaluate them in."""

    seconds: float
    steps: tuple[Step, ...]
    moment: EvaluationPoint
    is_cancelled: Callable[[], bool]
    outlives_shutdown: bool


class Evaluation:
    """Evaluation of a launch: the launch files before the start, then each event and timer.

    This class implements `Launch` for actions, and `Respondent` for the supervisor.

    Args:
        context: State that substitutions are evaluated with.
        builder: Evaluates actions to process plans.

    Attributes:
        context: State that substitutions are evaluated with.
        is_trial: Whether this is a dry run, which must have no effects outside.
        is_ending: Whether the launch shuts down, so that no more processes are started.
        skips_missing: Whether to skip actions whose packages, programs or files are not found.
        files_read: The user's files that were read for the start; empty without ``--watch``.
    """

    def __init__(self, context: LaunchContext, builder: ProcessBuilder) -> None:
        self.context = context
        context.launch = self
        self._shown = EnvironmentOverlay()
        self._builder = builder
        self._depth = 0
        self._trials = 0
        self._steps = Tally("steps", MOST_STEPS)
        self.is_trial = False
        self.skips_missing = False
        self.is_ending = False
        self.files_read: frozenset[Path] = frozenset()
        self._handlers: list[_Registered] = []
        self._follow_up = FollowUp()
        self._decisions: list[tuple[Callable[[], None], EvaluationPoint]] = []
        # Id of the thread that evaluates, and function that takes events of other threads.
        self._evaluates: int | None = None
        self._happened: Callable[[object], None] | None = None

    @property
    def scope(self) -> Scope:
        """Launch configurations, environment, namespace and so on for the next action."""
        return self.context.scope

    @property
    def uses_sim_time(self) -> bool:
        """Whether timers of ROS time follow ``/clock``; holds for the whole launch, as in ROS 2."""
        return self.context.uses_sim_time

    @uses_sim_time.setter
    def uses_sim_time(self, value: bool) -> None:
        self.context.uses_sim_time = value

    @property
    def file(self) -> Path:
        """The launch file that is being evaluated."""
        return self.context.file

    @property
    def event(self) -> object | None:
        """The event whose handlers run; None otherwise, such as before the start or in a timer."""
        return self.context.event

    def text(self, text: Template) -> str:
        """Return the text of a template with all substitutions evaluated."""
        return evaluated_text(text, self.context)

    def environment_value(self, name: str) -> str | None:
        """Return an environment variable's value for processes started now; None if unset."""
        return self.context.environment_value(name)

    def run_file(self, file: LaunchFile) -> None:
        """Evaluate all steps of a parsed launch file."""
        with self._evaluating(), self.context.inside(file.path):
            self.run(file.steps)

    def run(self, steps: tuple[Step, ...]) -> None:
        """Evaluate steps in order, skipping those whose conditions do not hold."""
        try:
            self._steps.add(1 + len(steps))
        except BudgetError as error:
            raise LaunchError(f"the launch takes {error}") from error
        for step in steps:
            self.apply_environment()
            try:
                with with_location(step.place):
                    if all(self._holds(condition) for condition in step.conditions):
                        self.run_action(step.action)
                        if step.done is not None:
                            step.done(self)
            except NotFoundError as error:
                if not self.skips_missing:
                    raise
                self.log("WARNING", f"left out: {error.message}", "launch")

    def apply_environment(self) -> None:
        """Set ``os.environ`` to the environment of the processes that are started at this point."""
        self._shown.show(self.scope.environment)

    def begin_user_code(self) -> None:
        """Apply the launch's environment to ``os.environ``, and record changes from now on."""
        self._shown.begin_user_code(self.scope.environment)

    @contextmanager
    def user_code(self) -> Iterator[None]:
        """Add changes of ``os.environ`` within the ``with`` block to the launch's environment."""
        self.begin_user_code()
        try:
            yield
        finally:
            self._shown.end_user_code(self.scope.environment)

    def _holds(self, condition: Condition) -> bool:
        text = self.text(condition.text)
        with self.context.reading(condition.text):
            return values.flag(text) == condition.expected

    def run_action(self, action: Action) -> None:
        """Evaluate an action and the actions that it returns; errors get no file and line here."""
        try:
            follow_up = tuple(action.evaluate(self) or ())
        except TeleopctlError:
            raise
        except Exception as error:
            raise LaunchError(
                f"{type(action).__name__} failed: {type(error).__name__}: {error}"
            ) from error
        for one in follow_up:
            self.run_action(one)

    def scoped(self) -> AbstractContextManager[None]:
        """Restore the scope (configurations, environment …) at the end of the ``with`` block."""
        return self.context.scoped()

    def include(self, path: Path) -> None:
        """Read and evaluate another launch file; raise if inclusions are nested too deeply."""
        if self._depth >= DEEPEST_INCLUDES:
            raise LaunchError(f"{path} is included more than {DEEPEST_INCLUDES} levels deep")
        self.context.count_included()
        self._depth += 1
        try:
            with self.user_code():
                file = read_launch_file(path)
            self.run_file(file)
        finally:
            self._depth -= 1

    def declare(self, name: str) -> None:
        """Record an argument as declared by the current launch file, not to be passed to xacro."""
        self.context.declare(name)

    def log(self, level: str, message: str, logger: str = "launch.user") -> None:
        """Queue a log line with level and logger name, written after the present evaluation."""
        self._follow_up.messages.append((level, logger, message))

    def start(self, process: ProcessPart) -> ProcessPlan:
        """Return a ``node`` or ``executable``'s plan; its process starts after the evaluation."""
        plan = self._builder.build(process)
        self._follow_up.processes.append(plan)
        return plan

    def plan_of(self, process: ProcessPart) -> ProcessPlan:
        """Return the plan of a ``node`` or ``executable``, whose process is not started."""
        return self._builder.copy(self.context).build(process)

    def ros_arguments_of(self, node: NodePart) -> tuple[list[str], str | None]:
        """Return a node's words from ``--ros-args`` on and its full name, with files written."""
        context = self.context
        if context.log_directory == Path():
            context.log_directory = _folder_without_launch()
        builder = self._builder.copy(context)
        found = builder.ros_arguments(node, f"node-{next(_numbers)}")
        if builder.files:
            context.log_directory.mkdir(parents=True, exist_ok=True)
            FollowUp(files=builder.files).write_files()
        return found

    def component(self, part: ComponentPart) -> ComponentPlan:
        """Return the plan for loading a component, evaluated from its description."""
        return self._builder.build_component(part)

    def count_node(self, full_name: str, logger: str) -> None:
        """Count a node of the launch by its full name; warn if there is another one."""
        self._builder.count(full_name, logger)

    def plan_of_node(self, full_name: str) -> ProcessPlan | None:
        """Return the plan of the process that runs a node, by the node's full name; or None."""
        return self._builder.plan_of_node(full_name)

    def action_of(self, plan: ProcessPlan) -> ProcessPart:
        """Return the ``node`` or ``executable`` action that a process plan was made from."""
        return self._builder.actions[plan.name]

    def after(
        self,
        seconds: float,
        steps: tuple[Step, ...],
        is_cancelled: Callable[[], bool] = bool,
        *,
        outlives_shutdown: bool = False,
    ) -> None:
        """Add a timer that runs steps after a delay in a copy of the scope, unless cancelled."""
        # The steps get a copy: settings do not pass between them and the actions after the timer.
        moment = EvaluationPoint(self.scope.copy(), self.file)
        timer = TimedSteps(max(0.0, seconds), steps, moment, is_cancelled, outlives_shutdown)
        self._follow_up.timers.append((timer.seconds, timer))

    def decide_last(self, decide: Callable[[], None]) -> None:
        """Call a function in a copy of the present scope, once all steps have been evaluated."""
        self._decisions.append((decide, EvaluationPoint(self.scope.copy(), self.file)))

    def work(self, work: Work) -> None:
        """Add background work, such as service calls; the launch starts and awaits the work."""
        self._follow_up.works.append(work)

    def register(self, handler: Handler, *, last: bool = False) -> None:
        """Register an event handler with the present scope: called first, or last if ``last``."""
        place = len(self._handlers) if last else 0
        self._handlers.insert(place, _Registered(handler, self.context.moment()))

    def unregister(self, handler: Handler) -> None:
        """Unregister an event handler; raise ValueError if it is not registered.

        Raises:
            ValueError: The handler is not registered.
        """
        found = next((entry for entry in self._handlers if entry.handler is handler), None)
        if found is None:
            raise ValueError("the event handler is not registered")
        self._handlers.remove(found)

    def has_handler_for(self, event: object) -> bool:
        """Return whether any registered handler would respond to an event."""
        return any(entry.handler.answers(event, self) for entry in self._handlers)

    def emit(self, event: object) -> None:
        """Queue an event for the registered handlers; any thread may call this."""
        if self._happened is None or self._evaluates == threading.get_ident():
            self._follow_up.events.append(event)
        else:
            self._happened(event)

    def shut_down(self, reason: str) -> None:
        """Request the shutdown of the launch, with a reason; any thread may call this."""
        if self._happened is None or self._evaluates == threading.get_ident():
            self._follow_up.shutdown = reason
        else:
            self._happened(ShutdownRequested(reason))

    def connect(self, on_event: Callable[[object], None]) -> None:
        """Set the function that takes events which other threads emit."""
        self._happened = on_event

    def disconnect(self) -> None:
        """Keep events that other threads emit in the follow-up, until the next `connect`."""
        self._happened = None

    @contextmanager
    def _evaluating(self) -> Iterator[None]:
        outer, self._evaluates = self._evaluates, threading.get_ident()
        if outer is None and not self.is_trial:
            tallies = (self._steps, self.context.characters, self.context.included)
            for tally in tallies:
                tally.count = 0
        try:
            yield
        finally:
            self._evaluates = outer
            if outer is None:
                self._shown.show({})

    @property
    def wants_output(self) -> bool:
        """Whether any registered handler takes output events of processes."""
        return any(entry.handler.wants_output for entry in self._handlers)

    def handle_event(self, event: object) -> FollowUp:
        """Run the handlers of an event; return the steps that the supervisor is to execute."""
        if isinstance(event, ShutdownBegan):
            self.is_ending = True
        with self._evaluating(), self.context.answering(event):
            if isinstance(event, ProcessEvent) and not isinstance(event, ProcessOutput):
                self._builder.notify_action(event)
                if isinstance(event, ProcessStarted) and event.was_saved:
                    return self.take_follow_up()
            for entry in tuple(self._handlers):
                with self.context.at(entry.moment):
                    self.apply_environment()
                    self.run(tuple(entry.handler.respond(event, self)))
            if isinstance(event, SignalRequested):
                self._follow_up.signals += self._builder.signals(event)
            elif isinstance(event, ShutdownRequested):
                self.shut_down(event.reason)
        return self.take_follow_up()

    def handle_timer(self, timer: LaunchTimer) -> FollowUp:
        """Run a launch timer's steps unless cancelled; return the steps for the supervisor."""
        assert isinstance(timer, TimedSteps)
        if not timer.is_cancelled():
            with self._evaluating(), self.context.at(timer.moment):
                self.run(timer.steps)
        return self.take_follow_up()

    def take_follow_up(self) -> FollowUp:
        """Return the collected follow-up (processes, timers, messages …), and begin a new one."""
        decisions, self._decisions = self._decisions, []
        for decide, moment in decisions:
            with self.context.at(moment):
                decide()
        follow_up, self._follow_up = self._follow_up, FollowUp()
        follow_up.files, self._builder.files = self._builder.files, {}
        return follow_up

    def dry_run(self, follow_up: FollowUp) -> Iterator[DryRun]:
        """Evaluate in advance the steps of timers and handlers; yield a dry run for each.

        Args:
            follow_up: Result of the last `take_follow_up`.
        """
        for _, timer in follow_up.timers:
            assert isinstance(timer, TimedSteps)
            yield self._tried(f"after {timer.seconds:g} s", timer.steps, timer.moment)
        for handler, moment in self._handlers:
            known = handler.dry_run()
            if known is not None:
                yield self._tried(*known, moment)

    def _tried(self, when: str, steps: tuple[Step, ...], moment: EvaluationPoint) -> DryRun:
        if self._trials >= DEEPEST_FORESIGHT:
            return DryRun(
                when, FollowUp(), LaunchError("the dry run does not look so far ahead"), ()
            )
        context = self.context.copy()
        trial = Evaluation(context, self._builder.copy(context))
        trial.is_trial = True
        # Nested dry runs share one budget of steps.
        trial._trials, trial._steps = self._trials + 1, self._steps
        trial.skips_missing = self.skips_missing
        error = None
        with trial._evaluating(), context.at(EvaluationPoint(moment.scope.copy(), moment.file)):
            try:
                trial.run(steps)
            except TeleopctlError as failed:
                error = failed
        follow_up = trial.take_follow_up()
        return DryRun(when, follow_up, error, tuple(trial.dry_run(follow_up)))
