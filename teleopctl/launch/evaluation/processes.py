"""Evaluation of ``node`` and ``executable`` actions to process plans."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from teleopctl.base.files import read_text
from teleopctl.base.typed import Callable, Final, Iterable, Sequence, TypeVar
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.parameters import parameter_file, parameter_value
from teleopctl.launch.evaluation.substitution import evaluated_text, evaluated_words
from teleopctl.launch.finding import is_builtin
from teleopctl.launch.model import values
from teleopctl.launch.model.descriptions import (
    ComponentPart,
    NodePart,
    ParameterEntry,
    ParameterFileEntry,
    ProcessPart,
    Words,
)
from teleopctl.launch.model.events import ProcessEvent, SignalRequested
from teleopctl.launch.model.output import BOTH, Output, OutputTable, output_alias, output_table
from teleopctl.launch.model.plan import ComponentPlan, ProcessPlan, SignalPlan
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.launch.model.scope import join_namespace
from teleopctl.launch.model.template import Template, TemplateError, literal, parse
from teleopctl.launch.model.values import split_command_line
from teleopctl.packages import find_executable, resolve_uri

_NODES: Final = ("teleopctl.nodes", "--builtin")

# By command: the module that replaces the command, and the words in front of its arguments.
COMMANDS: Final[dict[str, tuple[str, ...]]] = {
    "gazebo": (*_NODES, "gazebo_ros", "gazebo"),
    "gz": (*_NODES, "ros_gz_sim", "gz"),
    "gzclient": (*_NODES, "gazebo_ros", "gzclient"),
    "gzserver": (*_NODES, "gazebo_ros", "gzserver"),
    "ign": (*_NODES, "ros_gz_sim", "gz"),
    "ros2": ("teleopctl",),
    "xacro": (*_NODES, "xacro", "xacro"),
}


def find_command(name: str, path: str | None) -> str | None:
    """Return a command's path; just its name if teleopctl has a replacement; None if missing."""
    import shutil  # takes 2 ms

    return shutil.which(name, path=path) or (name if name in COMMANDS else None)


def replace_missing_command(words: Sequence[str], path: str | None) -> list[str]:
    """Return a command line; a Gazebo or ROS command not on the path becomes teleopctl's own."""
    name = words[0] if words else ""
    if name not in COMMANDS or find_command(name, path) != name:
        return list(words)
    return [sys.executable, "-P", "-m", *COMMANDS[name], *words[1:]]


def replace_missing_shell_command(line: str, path: str | None) -> str:
    """Return a shell line; a Gazebo or ROS command not on the path becomes teleopctl's own."""
    import shlex

    name, space, rest = line.lstrip().partition(" ")
    ours = replace_missing_command([name], path)
    return line if ours == [name] else f"{shlex.join(ours)}{space}{rest}"


# Programs that end by themselves: a launch is up when they have finished.
_PROGRAMS_THAT_END = frozenset(
    ("controller_manager", f"{name}{suffix}")
    for name in ("spawner", "unspawner", "hardware_spawner")
    for suffix in ("", ".py")
)
_SPAWNERS = frozenset(("controller_manager", f"spawner{suffix}") for suffix in ("", ".py"))
# Replacement of `ros2` in a command line on machines without it.
_OUR_ROS2 = [sys.executable, "-P", "-m", *COMMANDS["ros2"]]
_CONTAINERS = "teleopctl.nodes.component_container:"
_SIMULATOR = "teleopctl.nodes.mujoco_sim:"
# Programs with much to import that are of no use before the simulation runs.
_GIVING_WAY = tuple(f"teleopctl.nodes.{name}" for name in ("camera:", "moveit.", "rviz2:"))
_UNSAFE = re.compile(r"[^\w.\-]")

Value = TypeVar("Value")


def ends_by_itself(command: Sequence[str], *, shell: bool = False) -> bool:
    """Return whether a command line is ``ros2 control``, or ``ros2 run`` with a spawner.

    Args:
        command: Words of the command line; a single one for a shell.
        shell: Whether a shell runs it.
    """
    words = command[0].split() if shell else list(command)
    if words[: len(_OUR_ROS2)] == _OUR_ROS2:
        words = ["ros2", *words[len(_OUR_ROS2) :]]
    if Path(words[0]).name != "ros2":
        return False
    return words[1:2] == ["control"] or (
        words[1:2] == ["run"] and tuple(words[2:4]) in _PROGRAMS_THAT_END
    )


class ProcessBuilder:
    """Builder of the plans of a launch's processes and components, by evaluation of actions.

    Args:
        context: State that substitutions are evaluated with.
        request: Options of the launch.

    Attributes:
        actions: Actions that the processes were made from, by process name.
        files: Contents of the parameter files to write, by path.
    """

    def __init__(self, context: LaunchContext, request: LaunchRequest) -> None:
        self.actions: dict[str, ProcessPart] = {}
        self.files: dict[str, str] = {}
        self._plans: dict[str, ProcessPlan] = {}
        self._components = 0
        self._context = context
        self._request = request

    def copy(self, context: LaunchContext) -> ProcessBuilder:
        """Return a copy with the same processes, which evaluates with another context."""
        other = ProcessBuilder(context, self._request)
        other.actions.update(self.actions)
        other._plans.update(self._plans)
        other._components = self._components
        return other

    def build(self, action: ProcessPart) -> ProcessPlan:
        """Return the process plan of a ``node`` or ``executable``; record both by process name.

        Raises:
            TeleopctlError: The package, the program or a parameter file does not exist, or a value
                cannot be read.
        """
        shell = self._value(action.shell, "shell", values.boolean, default=False)
        package, program, target, command = self._program(action, shell=shell)
        if self._request.skip_missing and (package, program) in _SPAWNERS:
            # Plug-ins of a vendor's controllers may be missing as well. It is the first word, as
            # ROS arguments may follow.
            command.append("--keep-going")
        if action.arguments is not None:
            words = self._words(action.arguments, "args", shell=shell)
            command = [" ".join([*command, *words])] if shell else [*command, *words]
        stdout, stderr = self._outputs(action.output)
        name = self._optional(action.process_name) or program
        name = f"{_UNSAFE.sub('_', name)}-{len(self.actions) + 1}"
        node_name = None
        if action.node is not None:
            ros_arguments, node_name = self.ros_arguments(action.node, name)
            has_namespace = action.node.namespace is not None or self._context.scope.has_namespace
            if node_name is not None and has_namespace:
                self.count(node_name, name)
            command += [*ros_arguments, *self._requested_ros_arguments(program)]
        ends = (package, program) in _PROGRAMS_THAT_END or ends_by_itself(command, shell=shell)
        command = self._with_prefix(command, action.prefix, shell=shell)
        environment = dict(self._context.scope.environment)
        if action.clean_environment:
            environment = dict.fromkeys((*os.environ, *environment))
        environment.update(
            (self._text(variable), self._text(value)) for variable, value in action.environment
        )
        plan = ProcessPlan(
            name=name,
            command=command,
            environment=environment,
            working_directory=self._optional(action.working_directory),
            shell=shell,
            stdout=stdout,
            stderr=stderr,
            # In users' launch files, output appears as in ROS 2.
            is_quiet=action.output is None and is_builtin(self._context.file),
            emulate_tty=self._emulates_tty(action.emulate_tty),
            is_node=action.node is not None,
            node_name=node_name,
            loads_components=target.startswith(_CONTAINERS),
            simulates=target.startswith(_SIMULATOR),
            gives_way=target.startswith(_GIVING_WAY),
            ends_by_itself=ends,
            respawn=self._value(action.respawn, "respawn", values.boolean, default=False),
            respawn_delay=self._value(
                action.respawn_delay, "respawn_delay", values.number, default=0.0
            ),
            respawn_max_retries=self._value(
                action.respawn_max_retries, "respawn_max_retries", values.integer, default=-1
            ),
            shutdown_on_exit=self._value(
                action.shutdown_on_exit, "required", values.boolean, default=False
            )
            or program in self._request.required,
            sigterm_timeout=self._timeout(action.sigterm_timeout, "sigterm_timeout"),
            sigkill_timeout=self._timeout(action.sigkill_timeout, "sigkill_timeout"),
        )
        self.actions[name] = action
        self._plans[name] = plan
        return plan

    def build_component(self, part: ComponentPart) -> ComponentPlan:
        """Return the plan for loading a component; add its parameter files to `files`.

        Raises:
            TeleopctlError: A parameter file does not exist, or a value cannot be read.
        """
        scope = self._context.scope
        self._components += 1
        plugin, name = self._text(part.plugin), self._optional(part.name)
        label = _UNSAFE.sub("_", name or plugin.rpartition(":")[2])
        label = f"{label}-component-{self._components}"
        namespace = self._namespace(part.namespace)
        words = self._parameter_arguments((*scope.parameters, *part.parameters), label)
        if name:
            self.count(f"{namespace.rstrip('/')}/{name}", label)
        return ComponentPlan(
            package=self._text(part.package),
            plugin=plugin,
            name=name or None,
            namespace=namespace,
            parameter_files=tuple(word for word in words if word != "--params-file"),
            remaps=tuple(f"{source}:={target}" for source, target in self._remaps(part.remaps)),
            extra_arguments=tuple(
                (self._text(entry.name), self._parameter_value(entry))
                for entry in part.extra_arguments
            ),
            autostart=self._value(part.autostart, "autostart", values.boolean, default=False),
        )

    def ros_arguments(self, node: NodePart, process_name: str) -> tuple[list[str], str | None]:
        """Return a node's words from ``--ros-args`` on, and its full name if that is known.

        Args:
            node: The node.
            process_name: Name of its process, for messages and the names of parameter files.

        Raises:
            TeleopctlError: A parameter file does not exist, or a value cannot be read.
        """
        # In the order of ROS 2: the first of two conflicting arguments has precedence.
        words: list[str] = []
        if node.ros_arguments is not None:
            words += self._words(node.ros_arguments, "ros_args")
        name = self._optional(node.name)
        namespace = self._namespace(node.namespace)
        if name:
            words += ["-r", f"__node:={name}"]
        if namespace != "/":
            words += ["-r", f"__ns:={namespace}"]
        entries = (*self._context.scope.parameters, *node.parameters)
        words += self._parameter_arguments(entries, process_name)
        for source, target in self._remaps(node.remaps):
            words += ["-r", f"{source}:={target}"]
        full_name = f"{namespace.rstrip('/')}/{name}" if name else None
        return (["--ros-args", *words] if words else []), full_name

    def plan_of_node(self, full_name: str) -> ProcessPlan | None:
        """Return the plan of the process that runs a node, by the node's full name; or None."""
        return next((p for p in self._plans.values() if p.node_name == full_name), None)

    def count(self, node_name: str, process_name: str) -> None:
        """Count a node by its full name; warn in the name of a process if there is another one."""
        names = self._context.node_names
        names[node_name] += 1
        if names[node_name] > 1:
            self._warn(
                f"there are now at least {names[node_name]} nodes with the name {node_name} "
                "created within this launch context",
                process_name,
            )

    def notify_action(self, event: ProcessEvent) -> None:
        """Call the ``on_event`` callback, if any, of the action that made the event's process."""
        # The recorder has no action: it is not part of the launch file.
        action = self.actions.get(event.plan.name)
        if action is not None and action.on_event is not None:
            action.on_event(event)

    def signals(self, event: SignalRequested) -> list[SignalPlan]:
        """Return a `SignalPlan` for each process that a `SignalRequested` event selects."""
        return [
            SignalPlan(name, event.number)
            for name, action in self.actions.items()
            if event.matches(action, self._plans[name])
        ]

    def _program(self, action: ProcessPart, *, shell: bool) -> tuple[str, str, str, list[str]]:
        """Return package and target (both empty without package), program, and first words."""
        if action.node is not None and action.node.package is not None:
            package = self._text(action.node.package)
            program = self._text(action.node.executable)
            builtin = is_builtin(self._context.file)
            target = find_executable(package, program, builtin=builtin).target
            command = [sys.executable, "-P", "-m", "teleopctl.nodes"]
            command += [*(["--builtin"] if builtin else []), package, program]
            return package, program, target, command
        if action.node is not None:
            command = [self._text(action.node.executable)]
        else:
            assert action.command is not None
            command = self._words(action.command, "cmd", shell=shell)
        if shell:
            command = [" ".join(command)]
        if not command or not command[0].strip():
            raise LaunchError("'cmd': the command is empty")
        name = Path(command[0].split()[0] if shell else command[0]).name
        path = self._context.environment_value("PATH")
        ours = (
            [replace_missing_shell_command(command[0], path)]
            if shell
            else replace_missing_command(command, path)
        )
        return "", name, "", ours

    def _requested_ros_arguments(self, program: str) -> list[str]:
        """Return the ROS arguments that the launch request gives to a node."""
        given = self._request.ros_arguments
        words = [*given.get(program, ()), *given.get("", ())]
        return ["--ros-args", *words] if words else []

    def _namespace(self, own: Template | None) -> str:
        inner = self._optional(own)
        pushed = self._context.scope.namespace
        return join_namespace(pushed, inner) if inner else pushed

    def _remaps(self, own: Iterable[tuple[Template, Template]]) -> list[tuple[str, str]]:
        evaluated = ((self._text(source), self._text(target)) for source, target in own)
        return [*self._context.scope.remaps, *evaluated]

    def _parameter_arguments(
        self, entries: tuple[ParameterEntry | ParameterFileEntry, ...], process_name: str
    ) -> list[str]:
        """Return ``--params-file`` arguments; inline parameters between two files share a file."""
        words: list[str] = []
        inline: list[tuple[str, object]] = []
        count = 0

        def write_inline() -> None:
            nonlocal count
            if inline:
                count += 1
                suffix = f"-{count}" if count > 1 else ""
                path = self._context.log_directory / f"{process_name}-parameters{suffix}.yaml"
                self.files[str(path)] = parameter_file(inline)
                words.extend(["--params-file", str(path)])
                inline.clear()

        for entry in entries:
            if isinstance(entry, ParameterEntry):
                inline.append((self._text(entry.name), self._parameter_value(entry)))
                continue
            write_inline()
            path = resolve_uri(self._text(entry.path)).absolute()
            if not path.is_file():
                self._warn(f"Parameter file path is not a file: {path}", process_name)
                continue
            if self._allows_substitutions(entry):
                path = self._evaluated_file(path, process_name)
            words.extend(["--params-file", str(path)])
        write_inline()
        return words

    def _allows_substitutions(self, file: ParameterFileEntry) -> bool:
        if isinstance(file.allow_substs, bool):
            return file.allow_substs
        return self._value(file.allow_substs, "allow_substs", values.boolean, default=False)

    def _evaluated_file(self, path: Path, process_name: str) -> Path:
        """Evaluate the substitutions in a parameter file; return the path of the result."""
        import yaml

        from teleopctl.base import ros_yaml

        try:
            text = self._text(parse(read_text(path)))
            ros_yaml.load(text)
        except (TemplateError, TeleopctlError, yaml.YAMLError) as error:
            raise LaunchError(f"parameter file {path}: {error}") from error
        number = sum(f"{process_name}-{path.stem}" in name for name in self.files)
        suffix = f"-{number + 1}" if number else ""
        evaluated = self._context.log_directory / f"{process_name}-{path.stem}{suffix}.yaml"
        self.files[str(evaluated)] = text
        return evaluated

    def _warn(self, text: str, process_name: str) -> None:
        assert self._context.launch is not None
        self._context.launch.log("WARNING", text, process_name)

    def _parameter_value(self, entry: ParameterEntry) -> object:
        try:
            return parameter_value(entry, self._context)
        except TeleopctlError as error:
            if error.place is not None:
                raise
            raise LaunchError(
                f"parameter '{entry.name.source}': {error.message}", hint=error.hint
            ) from error

    def _with_prefix(
        self, command: list[str], prefix: Template | None, *, shell: bool
    ) -> list[str]:
        text = self._optional(prefix)
        if not text and self._request.prefix and self._fits_filter(command):
            text = self._request.prefix
        if not text:
            text = self._configured_prefix(command[0])
        if not text:
            return command
        if shell:
            return [f"{text} {command[0]}"]
        with values.at_key("launch-prefix"):
            return [*values.words(text), *command]

    def _fits_filter(self, command: list[str]) -> bool:
        pattern = self._request.prefix_filter
        if pattern is None:
            return True
        # teleopctl's programs are started by Python: their name follows the package's name.
        words = command[: command.index("--ros-args")] if "--ros-args" in command else command
        return any(re.fullmatch(f"(?:.*/)?(?:{pattern})", word) for word in words)

    def _outputs(self, output: Template | OutputTable | None) -> tuple[Output, Output]:
        """Return the destinations of stdout and stderr."""
        if self._request.show_all_output:
            return BOTH, BOTH
        overridden = self._context.environment_value("OVERRIDE_LAUNCH_PROCESS_OUTPUT")
        if overridden:
            return output_alias(overridden)
        if isinstance(output, dict):
            return output_table({key: frozenset(map(self._text, to)) for key, to in output.items()})
        return output_alias(self._optional(output) or "log")

    def _emulates_tty(self, text: Template | None) -> bool:
        configured = self._context.scope.variables.get("emulate_tty")
        if configured is not None:
            with values.at_key("emulate_tty"):
                return values.flag(configured)
        return self._value(text, "emulate_tty", values.flag, default=False)

    def _configured_prefix(self, program: str) -> str:
        """Return the prefix that launch configurations set, as ``ros2 launch`` does; or empty."""
        variables = self._context.scope.variables
        matches = re.match(variables.get("launch-prefix-filter", ""), Path(program).name)
        return variables.get("launch-prefix", "") if matches else ""

    def _timeout(self, text: Template | None, key: str) -> float:
        if text is None and key in self._context.scope.variables:
            text = literal(str(self._context.scope.variables[key]))
        return self._value(text, key, values.number, default=5.0)

    def _words(self, words: Words, key: str, *, shell: bool = False) -> list[str]:
        if isinstance(words, Template):
            if shell:
                return [self._text(words)]
            with values.at_key(key):
                words = split_command_line(words)
        return [text for word in words for text in evaluated_words(word, self._context)]

    def _text(self, text: Template) -> str:
        return evaluated_text(text, self._context)

    def _optional(self, text: Template | None) -> str | None:
        return None if text is None else self._text(text)

    def _value(
        self, text: Template | None, key: str, read: Callable[[str], Value], *, default: Value
    ) -> Value:
        if text is None:
            return default
        with values.at_key(key):
            evaluated = self._text(text)
            with self._context.reading(text):
                return read(evaluated)
