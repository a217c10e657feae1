"""Content of a launch file before evaluation: conditions, parameters, nodes, processes."""

from collections.abc import Callable
from pathlib import Path

from teleopctl.launch.model.output import OutputTable
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template


@dataclass(frozen=True, slots=True)
class Place:
    """File and line of an entry in a launch file.

    Attributes:
        file: The launch file.
        line: Line number, counted from 1.
    """

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True)
class Condition:
    """Condition ``if`` or ``unless`` of a launch action.

    Attributes:
        text: Text that evaluates to ``true``, ``1``, ``false`` or ``0``.
        expected: Value with which the action is executed: True for ``if``, False for ``unless``.
    """

    text: Template
    expected: bool


# A parameter's value: a template is evaluated and then typed, a scalar is used unchanged.
ParameterTree = Template | bool | int | float | str | list["ParameterTree"]


@dataclass(frozen=True, slots=True)
class ParameterEntry:
    """Parameter of a node in a launch file: name, value and type, not yet evaluated.

    Attributes:
        name: Dotted name of the parameter.
        value: Value of the parameter.
        type_name: Type that ``type:`` demands; None to type results of substitutions as YAML does.
    """

    name: Template
    value: ParameterTree
    type_name: str | None


@dataclass(frozen=True, slots=True)
class ParameterFileEntry:
    """Parameter file of a node in a launch file, not yet evaluated.

    Attributes:
        path: Path of the parameter file.
        allow_substs: Whether to evaluate substitutions in the file, as in a launch file.
    """

    path: Template
    allow_substs: Template | bool = False


# Words of a command line: a text that is split as a shell splits it, or one text for each word.
Words = Template | tuple[Template, ...]


@dataclass(frozen=True, slots=True)
class NodePart:
    """Attributes of a ``node`` action that an ``executable`` lacks, not yet evaluated.

    Attributes:
        package: Package that has the program; None if ``executable`` is a command.
        executable: Name of the program.
        name: Node name, or None for the one in the source.
        namespace: Namespace below the pushed ones, or None.
        parameters: Inline parameters and files, in order.
        remaps: Remappings, as pairs of from and to.
        ros_arguments: Further arguments after ``--ros-args``.
    """

    package: Template | None
    executable: Template
    name: Template | None = None
    namespace: Template | None = None
    parameters: tuple[ParameterEntry | ParameterFileEntry, ...] = ()
    remaps: tuple[tuple[Template, Template], ...] = ()
    ros_arguments: Words | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentPart:
    """Component to load into a container, as a launch file describes it, not yet evaluated.

    Attributes:
        place: File and line of the entry.
        conditions: Conditions that all have to hold for the component to be loaded.
        package: Package that has the component.
        plugin: Class of the component, such as ``composition::Talker``.
        name: Node name, or None for the one in the source.
        namespace: Namespace below the pushed ones, or None.
        parameters: Inline parameters and files, in order.
        remaps: Remappings, as pairs of from and to.
        extra_arguments: Arguments for the container.
        autostart: Whether to configure and activate the loaded node.
    """

    place: Place
    package: Template
    plugin: Template
    name: Template | None = None
    namespace: Template | None = None
    conditions: tuple[Condition, ...] = ()
    parameters: tuple[ParameterEntry | ParameterFileEntry, ...] = ()
    remaps: tuple[tuple[Template, Template], ...] = ()
    extra_arguments: tuple[ParameterEntry, ...] = ()
    autostart: Template | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessPart:
    """Attributes of a ``node`` or ``executable`` action, not yet evaluated.

    Attributes:
        node: Attributes of the node, or None for an ``executable``.
        command: Command line of an ``executable``; None for a node.
        arguments: Arguments after the program's name.
        process_name: Name in the output instead of the program's name, or None.
        working_directory: Working directory of the process, or None for the current one.
        environment: Environment variables to add, as name and value.
        clean_environment: Whether these are the whole environment of the process.
        prefix: Words before the command line.
        output: ``screen``, ``log``, ``both``, ``own_log`` or ``full``, or a table with the
            destinations of each stream; ``log`` still shows stderr, as in ROS 2.
        emulate_tty: Whether the process writes to a pseudo-terminal instead of a pipe.
        shell: Whether a shell executes the command line.
        respawn: Whether to restart the process when it ends.
        respawn_delay: Delay before a restart, in seconds.
        respawn_max_retries: Maximum number of restarts, -1 for any number.
        shutdown_on_exit: Whether the end of the process shuts the launch down.
        sigterm_timeout: Seconds from SIGINT to SIGTERM, or None for 5.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL, or None for 5.
        origin: Object of the front end that created this, for the front end's own use.
        on_event: Called with each event of the process, except output, before event handlers.
    """

    node: NodePart | None = None
    command: Words | None = None
    arguments: Words | None = None
    process_name: Template | None = None
    working_directory: Template | None = None
    environment: tuple[tuple[Template, Template], ...] = ()
    clean_environment: bool = False
    prefix: Template | None = None
    output: Template | OutputTable | None = None
    emulate_tty: Template | None = None
    shell: Template | None = None
    respawn: Template | None = None
    respawn_delay: Template | None = None
    respawn_max_retries: Template | None = None
    shutdown_on_exit: Template | None = None
    sigterm_timeout: Template | None = None
    sigkill_timeout: Template | None = None
    origin: object = None
    # object: an event, whose class is in a higher layer.
    on_event: Callable[[object], None] | None = None
