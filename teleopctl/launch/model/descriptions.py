"""Content of a launch file before evaluation: conditions, parameters, nodes, processes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from teleopctl.launch.model.output import OutputTable
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
        text: Has to evaluate to ``true``, ``1``, ``false`` or ``0``.
        expected: What the action needs the text to be.
    """

    text: Template
    expected: bool


# A parameter's value: a template is evaluated and then typed, a scalar is what it is.
ParameterTree = Template | bool | int | float | str | list["ParameterTree"]


@dataclass(frozen=True, slots=True)
class ParameterEntry:
    """Parameter of a node in a launch file: name, value and type, not yet evaluated.

    Attributes:
        name: Dotted name.
        value: Its value.
        type_name: The type that ``type:`` demands, or None to read what substitutions
            give as YAML does.
    """

    name: Template
    value: ParameterTree
    type_name: str | None


@dataclass(frozen=True, slots=True)
class ParameterFileEntry:
    """Parameter file of a node in a launch file, not yet evaluated.

    Attributes:
        path: The file.
        allow_substs: Whether substitutions in it are evaluated, as in a launch file.
    """

    path: Template
    allow_substs: Template | bool = False


# Words of a command line: a text that is split as a shell splits it, or one text for each word.
Words = Template | tuple[Template, ...]


@dataclass(frozen=True, slots=True)
class NodePart:
    """Attributes of a ``node`` action that an ``executable`` lacks, not yet evaluated.

    Attributes:
        package: Package that offers the program; None where ``executable`` is a command.
        executable: The program's name.
        name: Node name, or None for the one in the source.
        namespace: Namespace below the pushed ones, or None.
        parameters: Inline parameters and files, in order.
        remaps: Pairs from, to.
        ros_arguments: Further arguments behind ``--ros-args``.
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
        place: Where it stands.
        conditions: All have to hold for it to be loaded.
        package: Package that offers it.
        plugin: Its class, such as ``composition::Talker``.
        name: Node name, or None for the one in the source.
        namespace: Namespace below the pushed ones, or None.
        parameters: Inline parameters and files, in order.
        remaps: Pairs from, to.
        extra_arguments: Arguments for the container.
        autostart: Whether it is configured and activated once it is loaded.
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
        node: The node's part, or None for an ``executable``.
        command: The command line of an ``executable``; None for a node.
        arguments: Arguments behind the program's name.
        process_name: Name in the output in place of the program's, or None.
        working_directory: Folder to start in, or None for the current one.
        environment: Variables added for this process.
        clean_environment: Whether these are its whole environment.
        prefix: Words put before the command line.
        output: ``screen``, ``log``, ``both``, ``own_log`` or ``full``, or a table of where each
            stream goes; ``log`` still shows stderr, as in ROS 2.
        emulate_tty: Whether it is to think that it writes to a terminal.
        shell: Whether a shell reads the command line.
        respawn: Whether to start it again when it ends.
        respawn_delay: Seconds to wait before that.
        respawn_max_retries: How often, -1 for any number of times.
        shutdown_on_exit: Whether its end ends the launch.
        sigterm_timeout: Seconds from SIGINT to SIGTERM, or None for 5.
        sigkill_timeout: Seconds from SIGTERM to SIGKILL, or None for 5.
        origin: What a front end made this from, for its own use.
        told: Called with each event of the process before handlers answer it, but for output.
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
    # object: an event, which stands above this file.
    told: Callable[[object], None] | None = None
