"""From a launch file and its arguments to what is to be done, at the start and on each event.

The whole file is walked over before the first process starts, as in ROS 2. So nearly everything
that can go wrong goes wrong then: unknown packages, missing arguments, robot descriptions that do
not parse. What waits for an event or a timer is evaluated when it comes, with the launch variables
of the place where it stands.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import NamedTuple

from teleopctl.base.budget import (
    DEEPEST_FORESIGHT,
    DEEPEST_INCLUDES,
    MOST_STEPS,
    BudgetError,
    Tally,
)
from teleopctl.errors import LaunchError, NotFoundError, TeleopctlError, did_you_mean
from teleopctl.launch.evaluation.context import LaunchContext, Moment, located
from teleopctl.launch.evaluation.environment import ShownEnvironment
from teleopctl.launch.evaluation.processes import ProcessBuilder
from teleopctl.launch.evaluation.substitution import render
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Handler, LaunchFile, Step
from teleopctl.launch.model.descriptions import ComponentPart, Condition, ProcessPart
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
    """Steps that an event will cause, as far as they can be evaluated in advance.

    Attributes:
        when: The event in words.
        further: What it does then.
        error: Why not more is known of it, or None.
        then: What that leads to.
    """

    when: str
    further: FollowUp
    error: TeleopctlError | None
    then: tuple[DryRun, ...]


def faults(foreseen: Iterable[DryRun]) -> Iterator[TeleopctlError]:
    """Yield what the foreseen steps lack, such as packages and programs.

    Other errors may be none when the time has come.
    """
    for each in foreseen:
        if isinstance(each.error, NotFoundError):
            yield each.error
        yield from faults(each.then)


def undeclared(arguments: Iterable[str], declared: Collection[str]) -> list[str]:
    """Return a sentence for each launch argument that no file declares."""
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
    """Evaluate a launch file.

    Args:
        file: The parsed file.
        arguments: Launch arguments by name.
        log_directory: The launch's folder for logs and parameter files.
        request: How it is to be launched; by default as a request has it.
        again: An earlier evaluation of the file, whose processes run; this one has no effects.
        is_shown: Whether nothing is going to be started, so that a file that ends the launch before
            that is no mistake.

    Returns:
        What the launch does of itself, and what is to be asked when something happens.

    Raises:
        TeleopctlError: When anything in it cannot be evaluated; the message has file and line.
    """
    context = LaunchContext(arguments, log_directory)
    request = request or LaunchRequest(file=str(file.path))
    evaluation = Evaluation(context, ProcessBuilder(context, request))
    evaluation.skips_missing = request.skip_missing
    if again is not None:
        evaluation.is_trial = True
        context.take_names(again.context)
    evaluation.run_file(file)
    start = evaluation.take()
    if start.shutdown is not None and not is_shown:
        raise refusal(start.shutdown)
    for fault in faults(evaluation.foreseen(start)):
        raise fault
    unknown = undeclared(arguments, context.declared)
    warnings = [*context.warnings, *unknown]
    return LaunchPlan(log_directory=log_directory, start=start, warnings=warnings), evaluation


def refusal(reason: str, hint: str | None = None) -> LaunchError:
    """Return the error for a launch that its own file ends before the start."""
    error = LaunchError(reason, hint=hint)
    # Whoever wrote the file knows better than its line number what the person has to know.
    error.place = ""
    return error


class _Registered(NamedTuple):
    """A handler, and where the evaluation stood when it was registered."""

    handler: Handler
    moment: Moment


class Later(NamedTuple):
    """Steps that a timer runs later, with their point of the evaluation."""

    seconds: float
    steps: tuple[Step, ...]
    moment: Moment
    is_cancelled: Callable[[], bool]
    outlives_shutdown: bool


class Evaluation:
    """Evaluates a launch step by step: first the whole files, then event by event.

    It is the `Launch` that actions work with and the `Respondent` that the supervisor asks.

    Args:
        context: What substitutions look at.
        builder: Makes the processes.

    Attributes:
        context: What substitutions look at.
        is_trial: Whether this is a look ahead, which is to have no effects outside.
        is_ending: Whether the launch ends: nothing is started any more.
        skips_missing: Whether to go on without what is found nowhere.
        files_read: The user's files that were read for the start, where somebody wants to know.
    """

    def __init__(self, context: LaunchContext, builder: ProcessBuilder) -> None:
        self.context = context
        context.launch = self
        self._shown = ShownEnvironment()
        self._builder = builder
        self._depth = 0
        self._trials = 0
        self._steps = Tally("steps", MOST_STEPS)
        self.is_trial = False
        self.skips_missing = False
        self.is_ending = False
        self.files_read: frozenset[Path] = frozenset()
        self._handlers: list[_Registered] = []
        self._further = FollowUp()
        # Whose thread evaluates just now, and where events go that happen elsewhere.
        self._evaluates: int | None = None
        self._happened: Callable[[object], None] | None = None

    @property
    def scope(self) -> Scope:
        """Launch configurations, environment and namespace for the next step."""
        return self.context.scope

    @property
    def file(self) -> Path:
        """The launch file that is being evaluated."""
        return self.context.file

    @property
    def event(self) -> object | None:
        """The event being handled; None during the first walk over the files."""
        return self.context.event

    def text(self, text: Template) -> str:
        """Evaluate the substitutions of a text."""
        return render(text, self.context)

    def environment_value(self, name: str) -> str | None:
        """Return a variable of the processes' environment, or None."""
        return self.context.environment_value(name)

    def run_file(self, file: LaunchFile) -> None:
        """Evaluate a launch file."""
        with self._evaluating(), self.context.inside(file.path):
            self.run(file.steps)

    def run(self, steps: tuple[Step, ...]) -> None:
        """Evaluate steps."""
        try:
            self._steps.add(1 + len(steps))
        except BudgetError as error:
            raise LaunchError(f"the launch takes {error}") from error
        for step in steps:
            self.show_environment()
            try:
                with located(step.place):
                    if all(self._holds(condition) for condition in step.conditions):
                        self.perform(step.action)
                        if step.done is not None:
                            step.done(self)
            except NotFoundError as error:
                if not self.skips_missing:
                    raise
                self.say("WARNING", f"left out: {error.message}", "launch")

    def show_environment(self) -> None:
        """Set ``os.environ`` to the environment of the processes, during the evaluation."""
        self._shown.show(self.scope.environment)

    def begin_calling_out(self) -> None:
        """Allow a launch file's code to change ``os.environ``; `calling_out` ends this."""
        self._shown.begin_calling_out(self.scope.environment)

    @contextmanager
    def calling_out(self) -> Iterator[None]:
        """Apply a launch file's changes of ``os.environ`` in the block to the following steps."""
        self.begin_calling_out()
        try:
            yield
        finally:
            self._shown.end_calling_out(self.scope.environment)

    def _holds(self, condition: Condition) -> bool:
        text = self.text(condition.text)
        with self.context.reading(condition.text):
            return values.flag(text) == condition.expected

    def perform(self, action: Action) -> None:
        """Evaluate an action of a program, which has no place in a file."""
        try:
            further = tuple(action.evaluate(self) or ())
        except TeleopctlError:
            raise
        except Exception as error:
            raise LaunchError(
                f"{type(action).__name__} failed: {type(error).__name__}: {error}"
            ) from error
        for one in further:
            self.perform(one)

    def scoped(self) -> AbstractContextManager[None]:
        """Restore the scope at the end of the block."""
        return self.context.scoped()

    def include(self, path: Path) -> None:
        """Evaluate another launch file."""
        if self._depth >= DEEPEST_INCLUDES:
            raise LaunchError(f"{path} is included more than {DEEPEST_INCLUDES} levels deep")
        self.context.count_included()
        self._depth += 1
        try:
            with self.calling_out():
                file = read_launch_file(path)
            self.run_file(file)
        finally:
            self._depth -= 1

    def declare(self, name: str) -> None:
        """Declare a launch argument."""
        self.context.declare(name)

    def say(self, level: str, message: str, logger: str = "launch.user") -> None:
        """Log a line of the launch."""
        self._further.messages.append((level, logger, message))

    def start(self, process: ProcessPart) -> ProcessPlan:
        """Add the process of a ``node`` or an ``executable``."""
        plan = self._builder.build(process)
        self._further.processes.append(plan)
        return plan

    def plan_of(self, process: ProcessPart) -> ProcessPlan:
        """Return the plan of a process without adding the process to the launch."""
        return self._builder.copy(self.context).build(process)

    def component(self, part: ComponentPart) -> ComponentPlan:
        """Evaluate a component to load."""
        return self._builder.build_component(part)

    def plan_of_node(self, full_name: str) -> ProcessPlan | None:
        """Return the process with a node of this name; None if there is none so far."""
        return self._builder.plan_of_node(full_name)

    def action_of(self, plan: ProcessPlan) -> ProcessPart:
        """Return the action that a process was made from."""
        return self._builder.actions[plan.name]

    def after(
        self,
        seconds: float,
        steps: tuple[Step, ...],
        is_cancelled: Callable[[], bool] = bool,
        *,
        outlives_shutdown: bool = False,
    ) -> None:
        """Run steps after a delay, unless they are cancelled."""
        # What they set is theirs, and what is set behind them does not reach them.
        moment = Moment(self.scope.copy(), self.file)
        timer = Later(max(0.0, seconds), steps, moment, is_cancelled, outlives_shutdown)
        self._further.timers.append((timer.seconds, timer))

    def work(self, work: Work) -> None:
        """Start work that runs beside the processes, such as service calls."""
        self._further.works.append(work)

    def register(self, handler: Handler, *, last: bool = False) -> None:
        """Register an event handler: before the present ones, or after them."""
        place = len(self._handlers) if last else 0
        self._handlers.insert(place, _Registered(handler, self.context.moment()))

    def unregister(self, handler: Handler) -> None:
        """Unregister an event handler.

        Raises:
            ValueError: It is not registered.
        """
        found = next((entry for entry in self._handlers if entry.handler is handler), None)
        if found is None:
            raise ValueError("the event handler is not registered")
        self._handlers.remove(found)

    def is_awaited(self, event: object) -> bool:
        """Return whether a handler would respond to an event."""
        return any(entry.handler.answers(event, self) for entry in self._handlers)

    def emit(self, event: object) -> None:
        """Queue an event for the handlers; any thread may call this."""
        if self._happened is None or self._evaluates == threading.get_ident():
            self._further.events.append(event)
        else:
            self._happened(event)

    def shut_down(self, reason: str) -> None:
        """End the launch; any thread may call this."""
        if self._happened is None or self._evaluates == threading.get_ident():
            self._further.shutdown = reason
        else:
            self._happened(ShutdownRequested(reason))

    def connect(self, happened: Callable[[object], None]) -> None:
        """Set the function to call with events of other threads."""
        self._happened = happened

    def disconnect(self) -> None:
        """Queue events of other threads until the next `connect`."""
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
        """Whether any handler receives the output of processes."""
        return any(entry.handler.wants_output for entry in self._handlers)

    def answer(self, event: object) -> FollowUp:
        """Return the steps that follow from an event."""
        if isinstance(event, ShutdownBegan):
            self.is_ending = True
        with self._evaluating(), self.context.answering(event):
            if isinstance(event, ProcessEvent) and not isinstance(event, ProcessOutput):
                self._builder.tell(event)
                if isinstance(event, ProcessStarted) and event.was_saved:
                    return self.take()
            for entry in tuple(self._handlers):
                with self.context.at(entry.moment):
                    self.show_environment()
                    self.run(tuple(entry.handler.respond(event, self)))
            if isinstance(event, SignalRequested):
                self._further.signals += self._builder.signals(event)
            elif isinstance(event, ShutdownRequested):
                self.shut_down(event.reason)
        return self.take()

    def fire(self, timer: LaunchTimer) -> FollowUp:
        """Return the steps that follow from a timer."""
        assert isinstance(timer, Later)
        if not timer.is_cancelled():
            with self._evaluating(), self.context.at(timer.moment):
                self.run(timer.steps)
        return self.take()

    def take(self) -> FollowUp:
        """Return the steps that were collected since the last call."""
        further, self._further = self._further, FollowUp()
        further.files, self._builder.files = self._builder.files, {}
        return further

    def foreseen(self, further: FollowUp) -> Iterator[DryRun]:
        """Evaluate the steps of timers and events in advance, as far as possible.

        Args:
            further: What was returned last.
        """
        for _, timer in further.timers:
            assert isinstance(timer, Later)
            yield self._tried(f"after {timer.seconds:g} s", timer.steps, timer.moment)
        for handler, moment in self._handlers:
            known = handler.foreseen()
            if known is not None:
                yield self._tried(*known, moment)

    def _tried(self, when: str, steps: tuple[Step, ...], moment: Moment) -> DryRun:
        if self._trials >= DEEPEST_FORESIGHT:
            return DryRun(when, FollowUp(), LaunchError("so far ahead nothing is evaluated"), ())
        context = self.context.copy()
        trial = Evaluation(context, self._builder.copy(context))
        trial.is_trial = True
        # What leads to what leads to more is counted as a whole.
        trial._trials, trial._steps = self._trials + 1, self._steps
        trial.skips_missing = self.skips_missing
        error = None
        with trial._evaluating(), context.at(Moment(moment.scope.copy(), moment.file)):
            try:
                trial.run(steps)
            except TeleopctlError as failed:
                error = failed
        further = trial.take()
        return DryRun(when, further, error, tuple(trial.foreseen(further)))
