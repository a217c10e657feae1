"""Substitutions for launch files that take any robot; names are in `teleopctl.plugins`.

- ``$(robot FILE name:=value …)``: the robot description, with absolute mesh paths and with the
  launch arguments that the xacro file declares.
- ``$(robot-arguments FILE name:=value …)``: these arguments as a list.
- ``$(simulated-robot FILE HARDWARE …)``: the description with the simulator as hardware.
- ``$(robot-controllers FILE HARDWARE OTHERWISE)``: the parameter file of the robot's controllers.
- ``$(with-plugins FILE HARDWARE CONTROLLERS)``: that file with evaluated substitutions, and with
  controllers in place of Gazebo's plug-ins.
- ``$(robot-namespace FILE HARDWARE CONTROLLERS)``: the namespace of the controller manager.
- ``$(robot-is-controlled FILE HARDWARE)``: whether any joint can be commanded.
- ``$(robot-remappings FILE HARDWARE NAMESPACE NAME …)``: the remappings of the description's
  ros2_control plug-in.
"""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

from teleopctl.base.files import write_private
from teleopctl.base.typed import TYPE_CHECKING, Iterator, Mapping, Sequence
from teleopctl.errors import InvalidDescriptionError, LaunchError, TeleopctlError, UsageError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.extra_substitutions import (
    defines_controllers,
    file_controllers,
    namespaces_of_managers,
    read_parameters,
)
from teleopctl.launch.evaluation.substitution import Substitution, evaluated_text
from teleopctl.launch.model.template import Call, Template, TemplateError, parse
from teleopctl.packages import resolve_uri

if TYPE_CHECKING:
    from teleopctl.robot import ChosenControllers, MotionPlugins, RobotDescription

AS_DESCRIBED = "as_described"


def file_and_mappings(words: Sequence[str]) -> tuple[Path, dict[str, str]]:
    """Return the description file's path and the xacro arguments in words ``FILE name:=value``.

    The file may stand at any position, as on the command line of ``xacro``.

    Raises:
        LaunchError: The file is missing, or another argument is not ``name:=value``.
    """
    files = [word for word in words if ":=" not in word]
    for word in files[1:]:
        raise LaunchError(f"expected 'name:=value', got '{word}'")
    if not files:
        raise LaunchError("the robot description's file is missing")
    mappings = dict(word.split(":=", 1) for word in words if ":=" in word)
    return resolve_uri(files[0]).absolute(), mappings


def expand(words: Sequence[str], context: LaunchContext) -> str:
    """Return the URDF of the file in words ``FILE name:=value``, expanded with these arguments.

    Raises:
        TeleopctlError: An argument is not ``name:=value``, or the file cannot be expanded.
    """
    return context.robot_description(*file_and_mappings(words))


def _robot(words: Sequence[str], context: LaunchContext) -> str:
    from teleopctl.robot import with_absolute_mesh_paths

    file, mappings = file_and_mappings(words)
    given = context.arguments_for_robot(file, mappings)
    return with_absolute_mesh_paths(
        context.robot_description(file, {**given, **mappings}), file.parent
    )


def _robot_arguments(words: Sequence[str], context: LaunchContext) -> str:
    """Return the arguments as a YAML flow list, for a parameter of the web page's node."""
    file, mappings = file_and_mappings(words)
    arguments = {**context.arguments_for_robot(file, mappings), **mappings}
    return json.dumps([f"{name}:={value}" for name, value in arguments.items()])


def _simulated_robot(words: Sequence[str], context: LaunchContext) -> str:
    text, remarks = with_hardware(words, context)
    if context.launch is not None:
        for remark in remarks:
            context.launch.log("INFO", remark, "launch")
    return text


def with_hardware(words: Sequence[str], context: LaunchContext) -> tuple[str, tuple[str, ...]]:
    """Return a URDF with the simulator as hardware (unless ``as_described``), and remarks."""
    from teleopctl.robot import simulated

    file, hardware, *mappings = words
    if hardware == AS_DESCRIBED:
        return _robot([file, *mappings], context), ()
    text = _robot([file, f"hardware:={hardware}", *mappings], context)
    try:
        urdf, remarks = simulated(text)
    except InvalidDescriptionError as error:
        raise error.at(file) from error
    hint = f"; hardware:={AS_DESCRIBED} takes the description's own"
    return urdf, tuple(remark + (hint if not n else "") for n, remark in enumerate(remarks))


ROBOT = Substitution(_robot, 1, None)
ROBOT_ARGUMENTS = Substitution(_robot_arguments, 1, None)
SIMULATED_ROBOT = Substitution(_simulated_robot, 2, None)
XACRO = Substitution(expand, 1, None)


# Topic and node name by which the nodes of one launch find each other.
_DESCRIPTION = "robot_description"
_NODE = "controller_manager"


def _robot_remappings(words: Sequence[str], context: LaunchContext) -> str:
    """Return ROS arguments with the plug-in's ``<remapping>`` rules, for the controller manager.

    With names of topics after NAMESPACE, as controllers use them, the result is for another node
    instead: it maps these names, in that namespace or in none, to the remapped topics.
    """
    from teleopctl.robot import RobotDescription, controller_remappings

    file, hardware, namespace, *names = words
    text, _ = with_hardware([file, hardware], context)
    if "<remapping>" not in text:
        return ""
    kept: list[str] = []
    remarks: list[str] = []
    for rule in controller_remappings(RobotDescription.from_urdf(text)):
        try:
            source, target = _ends(rule, namespace)
        except TeleopctlError as error:
            remarks.append(f"<remapping>{rule}</remapping> has no effect: {error.message}")
            continue
        if source == f"{namespace}/{_DESCRIPTION}":
            remarks.append(
                f"<remapping>{rule}</remapping> has no effect: sim.yaml's nodes read {source}"
            )
        elif source != target:
            kept.append(rule)
    if not names and context.launch is not None:
        if kept:
            remarks.append(
                f"<plugin> of ros2_control remaps topics of controllers: {', '.join(kept)}"
            )
        for remark in remarks:
            context.launch.log("INFO", remark, "launch")
    rules = _of_names(names, kept, namespace) if names else iter(kept)
    return " ".join(shlex.join(("-r", rule)) for rule in rules)


def _ends(rule: str, namespace: str) -> tuple[str, str]:
    """Return both names of a remapping rule, expanded as in the controller manager.

    Raises:
        TeleopctlError: The rule is invalid, or would rename nodes.
    """
    from teleopctl.node import expand_name, parse_ros_arguments

    (parsed,) = parse_ros_arguments(["--ros-args", "-r", rule]).remaps
    if parsed.match.startswith("__"):
        raise UsageError("it would rename each controller")
    left = parsed.match.rpartition("://")[2]
    return (
        expand_name(left, parsed.node or _NODE, namespace or "/"),
        expand_name(parsed.replacement, parsed.node or _NODE, namespace or "/"),
    )


def _of_names(names: Sequence[str], rules: Sequence[str], namespace: str) -> Iterator[str]:
    from teleopctl.node import parse_ros_arguments

    words = [word for rule in rules for word in ("-r", rule)]
    arguments = parse_ros_arguments(["--ros-args", *words])
    for name in names:
        inside = name if name.startswith("/") else f"{namespace}/{name}"
        target = arguments.remap(inside, _NODE, namespace or "/", is_service=False)
        if target != inside:
            outside = f"/{name.lstrip('/')}"
            yield from (f"{each}:={target}" for each in dict.fromkeys((inside, outside)))


ROBOT_REMAPPINGS = Substitution(_robot_remappings, 3, None, words=True)


_NO_FILE = "its <parameters> {} is not a file"
_COMMENT_LINE = re.compile(r"^[ \t]*#.*", re.MULTILINE)


def _say(context: LaunchContext, *sentences: str) -> None:
    if context.launch is not None:
        for sentence in sentences:
            context.launch.log("INFO", sentence, "launch")


def _robot_controllers(words: Sequence[str], context: LaunchContext) -> str:
    """Return the description's controller file, else the last argument, else a generated file."""
    from teleopctl.robot import controller_parameter_files

    *robot, otherwise = words
    description, plugins = _described(robot, context)
    named = controller_parameter_files(description)
    if not named:
        return otherwise or str(_made_for(description, plugins, context))
    for path in named:
        if not resolve_uri(path).is_file():
            raise LaunchError(f"{robot[0]}: <plugin> of ros2_control: {_NO_FILE.format(path)}")
    own = resolve_uri(named[0]).absolute()
    if not otherwise and not defines_controllers(read_parameters(str(own))):
        # Launch files load the robot's controllers, from files that the description does not name.
        return str(_made_for(description, plugins, context, own))
    others = f"; not read: {', '.join(named[1:])}" if named[1:] else ""
    _say(context, f"Controllers of the description: {named[0]}{others}")
    return str(resolve_uri(named[0]).absolute())


def _described(
    words: Sequence[str], context: LaunchContext
) -> tuple[RobotDescription, MotionPlugins]:
    """Return a description with the wanted hardware, and replacements of its motion plug-ins."""
    from teleopctl.robot import MotionPlugins, RobotDescription, motion_plugins

    text, _ = with_hardware(words, context)
    description = RobotDescription.from_urdf(text)
    as_described = words[1] == AS_DESCRIBED
    return description, MotionPlugins() if as_described else motion_plugins(description)


def _with_plugins(words: Sequence[str], context: LaunchContext) -> str:
    """Return the controller file, or a copy with values of variables and plug-ins' controllers."""
    import yaml

    from teleopctl.node import copy_mark
    from teleopctl.robot import MotionPlugins

    *robot, controllers_file = words
    plugins = MotionPlugins()
    if robot[1] != AS_DESCRIBED:
        description, plugins = _described(robot, context)
        _say(context, *plugins.remarks, *_names_of_managers(description))
    path = resolve_uri(controllers_file)
    if not path.is_file():
        return controllers_file  # the node that reads the file reports this
    text = path.read_text(encoding="utf-8")
    more, name = "", "controllers_with_values.yaml"
    if plugins.controllers:
        parameters = yaml.safe_dump(plugins.as_parameters(), sort_keys=False)
        more, name = (
            f"\n# Gazebo's plug-ins of the description.\n{parameters}",
            "controllers_with_plugins.yaml",
        )
    filled = _filled(text, path.absolute(), robot, context)
    if not more and filled == text:
        return controllers_file
    file = context.log_directory / name
    file.parent.mkdir(parents=True, exist_ok=True)
    write_private(file, f"{filled}\n{copy_mark(path.absolute())}{more}")
    return str(file)


def _names_of_managers(description: RobotDescription) -> Iterator[str]:
    """Yield remarks on ros2_control plug-ins that give the controller manager another name."""
    for plugin in description.gazebo.plugins:
        for tag in ("controller_manager_name", "controller_manager_prefix_node_name"):
            name = plugin.parameter(tag).strip()
            if "ros2_control" in plugin.filename and name not in ("", "controller_manager"):
                yield f"<{tag}>{name}</{tag}> has no effect: it is called controller_manager here"


def _filled(text: str, path: Path, robot: Sequence[str], context: LaunchContext) -> str:
    """Return the text of a parameter file with its substitutions evaluated.

    ROS 2 evaluates the substitutions where the launch file says ``allow_substs``. Here variables
    are launch arguments, and arguments of the robot description with the values of its expansion.

    Raises:
        LaunchError: A variable has no value, or a substitution is invalid.
    """
    if "$(" not in text:
        return text
    text = _COMMENT_LINE.sub("", text)  # line numbers stay the same
    try:
        template = parse(text)
        used = list(_variables(template))
        described = _arguments_of_robot(robot, context) if used else {}
        context.declared.update(name for name, _ in used if name in context.arguments)
        values = {**described, **context.scope.variables}
        missing = {n: call for n, call in used if n not in values and len(call.arguments) == 1}
        if missing:
            raise _without_value(missing, text, path)
        with context.scoped():
            context.scope.variables.update(values)
            return evaluated_text(template, context)
    except (TemplateError, TeleopctlError) as error:
        if isinstance(error, TeleopctlError) and error.place is not None:
            raise
        hint = error.hint if isinstance(error, TeleopctlError) else None
        raise LaunchError(str(error), hint=hint).at(str(path)) from error


def _variables(template: Template) -> Iterator[tuple[str, Call]]:
    """Yield the names of the variables in a text, each with its ``$(var …)`` call."""
    for part in template.parts:
        if isinstance(part, Call):
            if (name := Template((part,), part.source).variable) is not None:
                yield name, part
            for argument in part.arguments:
                yield from _variables(argument.template)


def _without_value(missing: Mapping[str, Call], text: str, path: Path) -> LaunchError:
    calls = list(missing.values())
    line = text.count("\n", 0, text.index(calls[0].source)) + 1
    return LaunchError(
        f"{', '.join(call.source for call in calls)}: neither a launch argument nor an argument "
        "of the robot description has that name",
        hint=f"Give it after the launch file: {' '.join(f'{name}:=VALUE' for name in missing)}",
    ).at(f"{path}:{line}")


def _arguments_of_robot(words: Sequence[str], context: LaunchContext) -> Mapping[str, str]:
    """Return the arguments of a description with their values; without defaults that have ``$``."""
    from teleopctl.robot import xacro_arguments

    file, hardware, *more = words
    path, mappings = file_and_mappings(
        [file, *more] if hardware == AS_DESCRIBED else [file, f"hardware:={hardware}", *more]
    )
    given = {**context.arguments_for_robot(path, mappings), **mappings}
    taken = xacro_arguments(context.files_of_robot(path, given))
    plain = {name: value for name, value in taken.items() if value is not None and "$" not in value}
    return {**plain, **{name: given[name] for name in given if name in taken}}


def _robot_namespace(words: Sequence[str], context: LaunchContext) -> str:
    """Return the controller manager's namespace, from Gazebo's plug-in or the controller file.

    The file decides if it has no section for the plug-in's namespace.
    """
    from teleopctl.robot import controller_namespace

    *robot, controllers_file = words
    file = read_parameters(controllers_file)
    described = ""
    if "<namespace>" in with_hardware(robot, context)[0]:
        described = controller_namespace(_described(robot, context)[0])
    in_file = namespaces_of_managers(file)
    if described and (not in_file or file.for_node(f"{described}/controller_manager")):
        _say(context, f"Controllers run in {described}, as <plugin> of ros2_control has it")
        return described
    found, *others = in_file or [""]
    because = f"as {controllers_file} has it" + (f"; not in {', '.join(others)}" if others else "")
    if described:
        because = f"not in {described} of <plugin>, for which {controllers_file} has nothing"
    if found or described or others:
        _say(context, f"Controllers run in {found or '/'}, {because}")
    return found


def _robot_is_controlled(words: Sequence[str], context: LaunchContext) -> str:
    if words[1] == AS_DESCRIBED or _described(words, context)[0].ros2_control:
        return "true"
    _say(context, f"Nothing to control: no joint of {words[0]} moves, and it has no <ros2_control>")
    return "false"


def _made_for(
    description: RobotDescription,
    plugins: MotionPlugins,
    context: LaunchContext,
    own: Path | None = None,
) -> Path:
    """Write a parameter file of controllers for every joint that can be commanded; return its path.

    The parameters follow those of the robot's own file, if given. An ``update_rate`` in that file
    has precedence.
    """
    import yaml

    from teleopctl.node import copy_mark
    from teleopctl.robot import default_controllers

    file = context.log_directory / "controllers.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    # For any namespace of the controllers.
    sections = {
        f"/**/{n}": values for n, values in default_controllers(description, plugins).items()
    }
    because, before = "No controllers_file is given or described", ""
    if own is not None:
        because, before = f"{own} configures none", f"{own.read_text('utf-8')}\n{copy_mark(own)}"
        if any("update_rate" in values for _, values in read_parameters(str(own)).sections):
            del sections["/**/controller_manager"]["ros__parameters"]["update_rate"]
    text = yaml.safe_dump(sections, sort_keys=False)
    write_private(file, before + text)
    if description.ros2_control:
        _say(context, f"{because}: those of {file}")
    return file


def chosen_controllers(
    model: Path, arguments: Mapping[str, str], folder: Path
) -> ChosenControllers | None:
    """Return controllers and file that ``sim.yaml`` would choose; None without ``ros2_control``.

    Args:
        model: Path of the robot description.
        arguments: Arguments of ``sim.yaml`` and of the description, by name.
        folder: Folder for generated parameter files.

    Raises:
        TeleopctlError: The description or a controller file is invalid.
    """
    from teleopctl.robot import ChosenControllers

    context = LaunchContext(arguments, folder)
    robot = [str(model), "sim"]
    description, plugins = _described(robot, context)
    if not description.ros2_control:
        return None
    otherwise = arguments.get("controllers_file", "")
    first = otherwise or _robot_controllers([*robot, ""], context)
    file = _with_plugins([*robot, first], context)
    namespace = arguments.get("controllers_namespace") or _robot_namespace([*robot, file], context)
    names = arguments.get("controllers") or file_controllers([file, namespace], context)
    own = Path(first).parent != folder or bool(plugins.controllers)
    return ChosenControllers(resolve_uri(file).absolute(), namespace, tuple(names.split()), own)


ROBOT_CONTROLLERS = Substitution(_robot_controllers, 3, None)
ROBOT_IS_CONTROLLED = Substitution(_robot_is_controlled, 2, None)
ROBOT_NAMESPACE = Substitution(_robot_namespace, 3, None)
WITH_PLUGINS = Substitution(_with_plugins, 3, None)
