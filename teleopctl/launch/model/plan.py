"""Plan of a launch: processes, components, timers and so on, fully evaluated, as plain data.

A plan can be printed. The steps that follow from events are evaluated when the events happen.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl.base.files import write_private
from teleopctl.base.typed import Callable, Protocol
from teleopctl.errors import TeleopctlError
from teleopctl.launch.model.output import BOTH, LOG, Output
from teleopctl.launch.model.records import dataclass, field

REQUIRED = "process[{name}] was required: shutting down launched system"
"""Log message when the end of a required process shuts the launch down."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessPlan:
    """A process to start, with all values evaluated.

    Attributes:
        name: Name in the output, ``exec-N``.
        command: Program and arguments; one text for a shell when ``shell`` is set.
        environment: Variables that differ from the launch's own; None removes a variable.
        working_directory: Working directory of the process, or None for the current one.
        shell: Whether a shell executes the command.
        stdout: Destinations of stdout.
        stderr: Destinations of stderr.
        is_quiet: Whether a terminal gets only warnings and errors of what the process logs.
        emulate_tty: Whether the process writes to a pseudo-terminal instead of a pipe.
        is_node: Whether the process is a ROS node, which appears in the graph.
        node_name: Full name of the node if the launch file gives the name, or None.
        ends_by_itself: Whether the process ends when its work is done, as a spawner does.
        loads_components: Whether the process is one of teleopctl's component containers.
        accompanies: Whether the process is a companion, such as a recorder: the other processes
            start when it reports that it is ready, and it is terminated after they have ended.
        simulates: Whether the process is teleopctl's simulator.
        gives_way: Whether the process starts once the launch's simulator is ready, so that it does
            not slow the simulator's start: cameras, the page and motion planning.
        respawn: Whether to restart the process when it ends.
        respawn_delay: Delay before a restart, in seconds.
        respawn_max_retries: Maximum number of restarts, -1 for any number.
        shutdown_on_exit: Whether the end of the process shuts the launch down.
        sigterm_timeout: Seconds from SIGINT to SIGTERM.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL.
    """

    name: str
    command: list[str]
    environment: dict[str, str | None] = field(default_factory=dict)
    working_directory: str | None = None
    shell: bool = False
    stdout: Output = LOG
    stderr: Output = BOTH
    is_quiet: bool = False
    emulate_tty: bool = False
    is_node: bool = False
    node_name: str | None = None
    ends_by_itself: bool = False
    loads_components: bool = False
    accompanies: bool = False
    simulates: bool = False
    gives_way: bool = False
    respawn: bool = False
    respawn_delay: float = 0.0
    respawn_max_retries: int = -1
    shutdown_on_exit: bool = False
    sigterm_timeout: float = 5.0
    sigkill_timeout: float = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentPlan:
    """A component to load into a container, with all values evaluated.

    Attributes:
        package: Package that has the component.
        plugin: Class of the component.
        name: Node name, or None for the one in the source.
        namespace: Namespace of the node.
        parameter_files: Paths of parameter files; later files have precedence.
        remaps: Remapping rules ``from:=to``.
        extra_arguments: Arguments for the container, as name and value.
        autostart: Whether to configure and activate the loaded node.
    """

    package: str
    plugin: str
    name: str | None = None
    namespace: str = "/"
    parameter_files: tuple[str, ...] = ()
    remaps: tuple[str, ...] = ()
    extra_arguments: tuple[tuple[str, object], ...] = ()
    autostart: bool = False


@dataclass(frozen=True, slots=True)
class SignalPlan:
    """A signal to send to a process of the launch.

    Attributes:
        process: Name of the process.
        number: Number of the signal; None to terminate the process as a shutdown does, with harder
            signals if needed.
    """

    process: str
    number: int | None


class LaunchTimer(Protocol):
    """Interface of a timer whose steps the launch runs later."""

    def is_cancelled(self) -> bool:
        """Return whether the timer was cancelled."""

    @property
    def outlives_shutdown(self) -> bool:
        """Whether a shutdown waits for the timer instead of cancelling it."""


class Work(Protocol):
    """Interface of work beside the processes, such as service calls, that a launch waits for."""

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start the work; ``report`` is called at its end with the error or None, by any thread."""


@dataclass(slots=True, kw_only=True)
class FollowUp:
    """Steps of a launch that evaluation decided: processes, files, timers, messages, signals.

    Attributes:
        messages: Lines to log, as level, logger and text.
        files: Contents of the parameter files to write, by path.
        processes: Processes to start, in order.
        timers: Timers to start, with their delays in seconds.
        works: Work to start beside the processes.
        events: Events that the launch's own actions emit.
        signals: Signals to send.
        shutdown: Reason for a shutdown, or None.
    """

    messages: list[tuple[str, str, str]] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    processes: list[ProcessPlan] = field(default_factory=list)
    timers: list[tuple[float, LaunchTimer]] = field(default_factory=list)
    works: list[Work] = field(default_factory=list)
    events: list[object] = field(default_factory=list)
    signals: list[SignalPlan] = field(default_factory=list)
    shutdown: str | None = None

    def write_files(self) -> None:
        """Write the generated parameter files.

        Raises:
            OSError: A file cannot be written.
        """
        for path, content in self.files.items():
            write_private(path, content)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchPlan:
    """Evaluated launch file: the steps at the start, log folder and warnings.

    Attributes:
        log_directory: Folder for logs and parameter files, which need not exist yet.
        start: Steps at the start.
        warnings: Warnings of the evaluation.
    """

    log_directory: Path
    start: FollowUp
    warnings: list[str] = field(default_factory=list)

    @property
    def processes(self) -> list[ProcessPlan]:
        """Plans of the processes that are started first, in order."""
        return self.start.processes

    def write_files(self) -> None:
        """Create the log folder, and write the generated parameter files."""
        self.log_directory.mkdir(parents=True, exist_ok=True)
        self.start.write_files()


class Respondent(Protocol):
    """Interface of an evaluation that returns the steps for an event or a timer."""

    @property
    def wants_output(self) -> bool:
        """Whether any registered handler takes output events of processes."""

    def connect(self, on_event: Callable[[object], None]) -> None:
        """Set the function that takes events which other threads emit."""

    def handle_event(self, event: object) -> FollowUp:
        """Run the handlers of an event; return the steps that the supervisor is to execute.

        Raises:
            TeleopctlError: A step cannot be evaluated; the message has file and line.
        """

    def handle_timer(self, timer: LaunchTimer) -> FollowUp:
        """Run the steps of a launch timer; return the steps that the supervisor is to execute."""
