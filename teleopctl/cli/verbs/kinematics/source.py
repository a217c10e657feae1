"""Robot of a ``kinematics`` command: that of a file, or the running one."""

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.verb import Option, OptionSet
from teleopctl.errors import TeleopctlError, UsageError

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.commander import RunningRobot
    from teleopctl.kinematics import Arm


def render_nothing() -> None:
    """Disable mujoco's renderers, which a command of kinematics does not need.

    mujoco reads the variable at import.
    """
    os.environ["MUJOCO_GL"] = "disable"


class Words(NamedTuple):
    """Arguments of a command line, by kind.

    Attributes:
        file: Robot's file; None for the robot that runs.
        arguments: Arguments of a xacro file, by name.
        numbers: Numbers in their order.
        joints: Positions by joint.
        names: Other words.
    """

    file: str | None
    arguments: dict[str, str]
    numbers: list[float]
    joints: dict[str, float]
    names: list[str]


def sorted_words(words: Iterable[str]) -> Words:
    """Sort words ``FILE``, ``name:=value``, ``1.5``, ``joint=1.5`` and ``name``.

    Raises:
        UsageError: The value of a joint is not a finite number.
    """
    found = Words(None, {}, [], {}, [])
    file = None
    for word in words:
        name, is_argument, value = word.partition(":=")
        if is_argument:
            found.arguments[name] = value
            continue
        name, is_joint, value = word.partition("=")
        if is_joint and name and "/" not in name:
            found.joints[name] = number(value, f"the position of joint '{name}'")
            continue
        parts = word.split(",")
        try:
            found.numbers.extend([float(part) for part in parts])
        except ValueError:
            if file is None and not found.numbers and not found.names and _is_file(word):
                file = word
            else:
                found.names.append(word)
    for given in found.numbers:
        if not math.isfinite(given):
            raise UsageError(f"{given} is no finite number")
    if found.arguments and file is None:
        raise UsageError(
            f"{next(iter(found.arguments))}:= is an argument of a xacro file, and no file is given"
        )
    return found._replace(file=file)


def _is_file(word: str) -> bool:
    return "/" in word or "." in word or Path(word).is_file()


def number(text: str, what: str) -> float:
    """Return the finite number of a text.

    Raises:
        UsageError: The text is no number.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"'{text}' for {what} is no finite number")
    return value


def numbers(text: str, count: int, option: str, form: str) -> list[float]:
    """Return numbers with commas (or blanks) between them.

    Args:
        text: The text.
        count: How many there must be.
        option: The option, for messages.
        form: Their names, such as ``x,y,z``.

    Raises:
        UsageError: There is another number of them, or one is not finite.
    """
    parts = text.replace(",", " ").split()
    if len(parts) != count:
        raise UsageError(f"{option} takes {count} numbers, {form}; got '{text}'")
    return [number(part, option) for part in parts]


class RobotOptions(OptionSet):
    """Options that choose group, tool and files of a robot."""

    group: Annotated[
        str | None,
        Option(
            "-g",
            "--group",
            help="Group of joints; by default the first that moves a tip.",
            metavar="GROUP",
            complete="groups",
        ),
    ] = None
    tool: Annotated[
        str | None,
        Option(
            "--tool",
            help="Link that poses are about, or x,y,z[,roll,pitch,yaw] in the frame of the tip.",
            metavar="FRAME",
            complete="links",
        ),
    ] = None
    srdf: Annotated[
        str | None,
        Option(
            "--srdf",
            help="SRDF with groups and states; by default /robot_description_semantic, or what "
            "the description suggests.",
            metavar="FILE",
            complete="files",
        ),
    ] = None
    namespace: Annotated[
        str,
        Option("-n", "--namespace", help="Namespace of the running robot.", metavar="NAMESPACE"),
    ] = ""

    def tool_frame(self) -> str | list[float] | None:
        """Return the tool as `Arm` takes it."""
        if not self.tool or not ("," in self.tool or self.tool.lstrip("-")[:1].isdigit()):
            return self.tool
        count = 6 if self.tool.count(",") > 2 else 3
        return numbers(self.tool, count, "--tool", "x,y,z or x,y,z,roll,pitch,yaw")


def arm_of(robot: "RunningRobot", options: RobotOptions) -> "Arm":
    """Return the chosen group as an `Arm` at the measured positions, else at rest; print warnings.

    Raises:
        NotFoundError: There is no such group or tool.
        UnavailableError: A joint of the group has no measured position.
    """
    render_nothing()
    arm, warnings = robot.arm(options.group or "", options.tool_frame())
    for warning in warnings:
        console.warn(warning)
    return arm


def robot_of_file(words: Words, options: RobotOptions) -> "RunningRobot":
    """Return the robot of a command's file.

    Raises:
        InvalidDescriptionError: The file cannot be read.
        NotFoundError: There is no such file.
    """
    render_nothing()
    from teleopctl.commander import RunningRobot
    from teleopctl.kinematics import find_groups, load_description, read_srdf
    from teleopctl.packages import resolve_uri

    assert words.file is not None
    if options.namespace:
        raise UsageError("--namespace is about the running robot, and a file is given")
    description = load_description(resolve_uri(words.file), words.arguments)
    groups = (
        read_srdf(Path(options.srdf), description) if options.srdf else find_groups(description)
    )
    return RunningRobot(description, groups, None)


def read_robot(words: Words, options: RobotOptions, *, needs_state: bool) -> "RunningRobot":
    """Return the robot of a command's file, or the one that runs.

    Args:
        words: The command's words.
        options: The command's options.
        needs_state: Whether the positions of the running robot's joints are needed.

    Raises:
        NotFoundError: There is no such file; or no robot runs, or several.
        UnavailableError: The running robot's topics are silent.
    """
    if words.file is not None:
        return robot_of_file(words, options)
    from teleopctl.cli.command_node import brief_node

    render_nothing()
    from teleopctl.commander import receive_robot

    with brief_node() as node:
        return receive_robot(node, options.namespace, options.srdf, needs_state=needs_state)


# --- completion ---------------------------------------------------------------------------------


def complete_groups(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return the names of groups of the command's robot that begin with a text."""
    return _candidates(ctx, incomplete, lambda robot: robot.groups.groups)


def complete_links(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return the names of links that the command's group moves and that begin with a text."""
    from teleopctl.kinematics import moved_links

    return _candidates(
        ctx,
        incomplete,
        lambda robot: moved_links(
            robot.groups.group(str(ctx.params.get("group") or "")), robot.description
        ),
    )


def complete_all_links(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return the names of links of the command's robot that begin with a text."""
    return _candidates(ctx, incomplete, lambda robot: robot.description.links)


def complete_named_states(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return the names of states of the command's group that begin with a text."""
    return _candidates(
        ctx,
        incomplete,
        lambda robot: robot.groups.states.get(
            robot.groups.group(str(ctx.params.get("group") or "")).name, {}
        ),
    )


def complete_joints(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return files, and ``joint=`` for the joints of the command's group."""
    from teleopctl.cli.completion.candidates import files

    def joints(robot: "RunningRobot") -> list[str]:
        group = robot.groups.group(str(ctx.params.get("group") or ""))
        return [f"{name}=" for name in group.joints]

    has_file = sorted_words(_typed_words(ctx)).file is not None
    return [
        *([] if has_file else files(incomplete)),
        *_candidates(ctx, incomplete, joints),
    ]


def _typed_words(ctx: "TypedWords") -> list[str]:
    return list(ctx.params.get("words") or ())


def _candidates(
    ctx: "TypedWords", incomplete: str, names: Callable[["RunningRobot"], Iterable[str]]
) -> list[str]:
    options = RobotOptions(
        srdf=ctx.params.get("srdf") or None, namespace=str(ctx.params.get("namespace") or "")
    )
    try:
        robot = read_robot(sorted_words(_typed_words(ctx)), options, needs_state=False)
        return [name for name in names(robot) if name.startswith(incomplete)]
    except (TeleopctlError, OSError):
        return []
