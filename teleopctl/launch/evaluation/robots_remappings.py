"""A substitution for the names that the description's plug-in of ros2_control gives to topics.

``$(robot-remappings FILE HARDWARE NAMESPACE NAME …)``: its name stands in `teleopctl.plugins`.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence

from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.launch.evaluation.context import LaunchContext
from teleopctl.launch.evaluation.robots import with_hardware
from teleopctl.launch.evaluation.substitution import Substitution

# By which the nodes of one launch find one another.
_DESCRIPTION = "robot_description"
_NODE = "controller_manager"


def _robot_remappings(words: Sequence[str], context: LaunchContext) -> str:
    """ROS arguments with the plug-in's ``<remapping>``, for the node that runs its controllers.

    Behind NAMESPACE names may follow, as controllers know them: then those arguments by which
    another node, there or in no namespace, finds these, whatever they have become.
    """
    from teleopctl.robot import RobotDescription, described_remappings

    file, hardware, namespace, *names = words
    text, _ = with_hardware([file, hardware], context)
    if "<remapping>" not in text:
        return ""
    kept: list[str] = []
    remarks: list[str] = []
    for rule in described_remappings(RobotDescription.from_urdf(text)):
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
                f"<plugin> of ros2_control remaps what controllers publish and hear: "
                f"{', '.join(kept)}"
            )
        for remark in remarks:
            context.launch.say("INFO", remark, "launch")
    rules = _of_names(names, kept, namespace) if names else iter(kept)
    return " ".join(shlex.join(("-r", rule)) for rule in rules)


def _ends(rule: str, namespace: str) -> tuple[str, str]:
    """The two names of a rule, as the controller manager has them.

    Raises:
        TeleopctlError: It is no rule, or one for the names of nodes.
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
