"""The robot of a command: that of a file, or the one that runs."""

import math
import os
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.verb import Option, OptionSet
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError, UsageError

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.kinematics import Arm, RobotGroups
    from teleopctl.node import BareNode, Node
    from teleopctl.robot import RobotDescription

# Longest waits for a latched description, and for a first state of the joints, in seconds.
_DESCRIPTION_S, _STATES_S = 3.0, 2.0
# How far (rad or m) a measured position may be outside its limits without a note: sensors' noise.
_NOISE = 0.01
_STRING = "std_msgs/msg/String"


def render_nothing() -> None:
    """Let mujoco load no renderer, which a command of kinematics does not need.

    mujoco reads the variable at import.
    """
    os.environ["MUJOCO_GL"] = "disable"


class Words(NamedTuple):
    """The words of a command line, sorted.

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
        UsageError: It is none.
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


class RobotOfCommand(NamedTuple):
    """A robot's description and groups, and where its joints are.

    Attributes:
        description: The robot.
        groups: Its groups.
        positions: Measured positions by joint; None if the robot does not run.
        compute_ik: Name of the service of a running move_group; empty without one.
    """

    description: "RobotDescription"
    groups: "RobotGroups"
    positions: dict[str, float] | None
    compute_ik: str = ""

    def arm(self, options: RobotOptions) -> "Arm":
        """Return the chosen group as an `Arm` at the measured positions, else at rest.

        Raises:
            NotFoundError: There is no such group or tool.
            UnavailableError: A joint of the group has no measured position.
        """
        render_nothing()
        from teleopctl.kinematics import Arm

        arm = Arm(self.description, options.group or "", options.tool_frame(), self.groups)
        for warning in self.groups.warnings:
            console.warn(warning)
        for first, second in arm.model.touching:
            console.warn(
                f"'{first}' and '{second}' touch at nearly all joint positions: they are allowed to"
            )
        if self.positions is not None:
            unknown = [
                name for name in arm.names if not math.isfinite(self.positions.get(name, math.nan))
            ]
            if unknown:
                raise UnavailableError(
                    f"The joint states have no position of {', '.join(unknown)}",
                    hint=f"They have: {', '.join(self.positions) or 'none'}",
                )
            arm.model.set_positions(self.positions)
            measured = arm.kinematics.present()
            arm.positions = arm.kinematics.clamp(measured)
            for name, at, moved in zip(arm.names, measured, arm.positions, strict=True):
                if abs(at - moved) > _NOISE:
                    console.warn(f"Joint '{name}' is at {at:.4g}, outside its limits")
        return arm


def robot_of_file(words: Words, options: RobotOptions) -> RobotOfCommand:
    """Return the robot of a command's file.

    Raises:
        InvalidDescriptionError: The file cannot be read.
        NotFoundError: There is no such file.
    """
    render_nothing()
    from teleopctl.kinematics import find_groups, load_description, read_srdf
    from teleopctl.packages import resolve_uri

    assert words.file is not None
    if options.namespace:
        raise UsageError("--namespace is about the running robot, and a file is given")
    description = load_description(resolve_uri(words.file), words.arguments)
    groups = (
        read_srdf(Path(options.srdf), description) if options.srdf else find_groups(description)
    )
    return RobotOfCommand(description, groups, None)


def read_robot(words: Words, options: RobotOptions, *, needs_state: bool) -> RobotOfCommand:
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

    with brief_node() as node:
        return running_robot(node, options, needs_state=needs_state)


def running_robot(
    node: "Node | BareNode", options: RobotOptions, *, needs_state: bool
) -> RobotOfCommand:
    """Return the robot that runs; see `read_robot`.

    Args:
        node: "Node" of the subscriptions.
        options: The command's options.
        needs_state: Whether the positions of its joints are needed.
    """
    above = f"/{options.namespace.strip('/')}" if options.namespace.strip("/") else ""
    topic = f"{above}/robot_description"
    graph = node.graph()
    publishers = graph.publishers(topic, _STRING)
    if not publishers:
        others = sorted(
            name.removesuffix("/robot_description")
            for name, _ in graph.topic_names_and_types()
            if name.endswith("/robot_description") and graph.publishers(name, _STRING)
        )
        raise NotFoundError(
            f"No robot runs: nothing publishes {topic}",
            hint=f"Others do in: {', '.join(each or '/' for each in others)} (--namespace)"
            if others
            else "Give a robot's FILE, or start one: teleopctl launch sim.yaml",
        )
    received = _Received(node, topic, f"{above}/joint_states", needs_state=needs_state)
    semantic = f"{topic}_semantic"
    if graph.publishers(semantic, _STRING) and not options.srdf:
        received.subscribe_semantic(semantic)
    # The messages arrive while these are imported, which takes longer.
    render_nothing()
    from teleopctl.kinematics import Arm as Arm, find_groups, parse_srdf, read_srdf
    from teleopctl.robot import RobotDescription

    received.wait(len(publishers))
    texts = set(received.descriptions)
    if len(texts) > 1:
        names = ", ".join(sorted({each.full_name for each in publishers}))
        raise NotFoundError(
            f"{topic} has the descriptions of {len(texts)} robots, by {names}",
            hint="Robots in one graph need namespaces of their own.",
        )
    description = RobotDescription.from_urdf(received.descriptions[0])
    if options.srdf:
        groups = read_srdf(Path(options.srdf), description)
    elif received.semantic:
        groups = parse_srdf(received.semantic, description)
    else:
        groups = find_groups(description)
    service = f"{above}/compute_ik"
    return RobotOfCommand(
        description, groups, received.positions, service if graph.servers(service) else ""
    )


class _Received:
    """Subscriber of a running robot's description, groups and joint states."""

    def __init__(
        self,
        node: "Node | BareNode",
        description_topic: str,
        states_topic: str,
        *,
        needs_state: bool,
    ) -> None:
        from teleopctl.interfaces import get_message
        from teleopctl.node import qos_profile_latched, qos_profile_sensor_data

        self.descriptions: list[str] = []
        self.semantic = ""
        self.positions: dict[str, float] | None = None
        self._node, self._needs_state = node, needs_state
        self._topics = (description_topic, states_topic)
        self._wants_semantic = False
        self._changed = threading.Condition()
        self._latched = qos_profile_latched
        node.create_subscription(
            get_message(_STRING),
            description_topic,
            self._take_description,
            qos_profile_latched,
            immediate=True,
        )
        if needs_state:
            node.create_subscription(
                get_message("sensor_msgs/msg/JointState"),
                states_topic,
                self._take_state,
                qos_profile_sensor_data,
                immediate=True,
            )

    def subscribe_semantic(self, topic: str) -> None:
        """Receive the SRDF as well."""
        from teleopctl.interfaces import get_message

        self._wants_semantic = True
        self._node.create_subscription(
            get_message(_STRING), topic, self._take_semantic, self._latched, immediate=True
        )

    def wait(self, publishers: int) -> None:
        """Wait until the description and what else is needed have come.

        Raises:
            UnavailableError: The description, or the joints' state, does not come.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: (
                    len(self.descriptions) >= publishers
                    and (self.semantic or not self._wants_semantic)
                ),
                _DESCRIPTION_S,
            )
            if not self.descriptions:
                raise UnavailableError(f"{self._topics[0]} has a publisher that sends nothing")
            if self._needs_state and not self._changed.wait_for(
                lambda: self.positions is not None, _STATES_S
            ):
                raise UnavailableError(
                    f"No joint states on {self._topics[1]} within {_STATES_S:g} s",
                    hint="A joint_state_broadcaster or joint_state_publisher publishes them; a "
                    "command with positions, --named or --start needs none.",
                )

    # Any, here and below: message classes are generated at run time from definitions.
    def _take_description(self, message: Any) -> None:
        with self._changed:
            self.descriptions.append(str(message.data))
            self._changed.notify_all()

    def _take_semantic(self, message: Any) -> None:
        with self._changed:
            self.semantic = str(message.data)
            self._changed.notify_all()

    def _take_state(self, message: Any) -> None:
        with self._changed:
            found = dict(zip(message.name, map(float, message.position), strict=False))
            self.positions = {**(self.positions or {}), **found}
            self._changed.notify_all()


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

    def joints(robot: RobotOfCommand) -> list[str]:
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
    ctx: "TypedWords", incomplete: str, names: Callable[[RobotOfCommand], Iterable[str]]
) -> list[str]:
    options = RobotOptions(
        srdf=ctx.params.get("srdf") or None, namespace=str(ctx.params.get("namespace") or "")
    )
    try:
        robot = read_robot(sorted_words(_typed_words(ctx)), options, needs_state=False)
        return [name for name in names(robot) if name.startswith(incomplete)]
    except (TeleopctlError, OSError):
        return []
