"""``teleopctl kinematics srdf``: writes an SRDF for a robot, or checks one."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.kinematics.source import RobotOptions, read_robot, sorted_words
from teleopctl.errors import RefusedError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from teleopctl.kinematics import RobotGroups


def srdf(
    words: Annotated[
        list[str] | None,
        Argument(
            help="Robot's file with arguments of its xacro, or none for the running robot.",
            metavar="[FILE [name:=value]…]",
            complete="files",
        ),
    ] = None,
    check: Annotated[
        str | None,
        Option("--check", help="Check this SRDF instead.", metavar="FILE", complete="files"),
    ] = None,
    output: Annotated[
        str | None, Option("-o", "--output", help="Write to a file.", metavar="FILE")
    ] = None,
    force: Annotated[bool, Option("--force", help="Replace an existing file.")] = False,
    samples: Annotated[
        int,
        Option(
            "--samples",
            help="Random joint positions by which collisions are sorted.",
            metavar="NUMBER",
        ),
    ] = 10_000,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> int:
    """Write an SRDF: groups, named states, end effectors, and links that need no collision check.

    Groups and states are found in the description, or read with ``--srdf``. Pairs of links are
    sorted as MoveIt's setup assistant does: Adjacent (on either side of a joint), Default (touching
    at rest), Always (at 95 % of random positions or more) and Never. ``--check`` prints what an
    SRDF says that the robot has not, with its lines, and ends with status 1 if there is anything.
    """
    from dataclasses import replace

    found = sorted_words(words or ())
    if found.numbers or found.joints or found.names:
        raise UsageError("This takes a robot's file and arguments of its xacro only")
    if samples < 1:
        raise UsageError(f"--samples must be at least 1, got {samples}")
    if output is not None and Path(output).exists() and not force:
        raise RefusedError(f"{output} exists", hint="--force replaces it.")
    read = read_robot(found, robot, needs_state=False)
    # After the robot is read, whose reader sets mujoco to load no renderer.
    from teleopctl.kinematics import KinematicModel, allowed_by_sampling, read_srdf, write_srdf

    if check is not None:
        groups = read_srdf(Path(check), read.description)
        if as_json:
            console.out_json({**_document(groups), "warnings": list(groups.warnings)})
        else:
            console.out_lines(groups.warnings or _summary(groups))
        return int(bool(groups.warnings))
    for warning in read.groups.warnings:
        console.warn(warning)
    model = KinematicModel(read.description)
    allowed = allowed_by_sampling(
        read.description,
        model.mj_model,
        model.joints,
        model.links,
        model.mj_data.qpos.copy(),
        samples,
    )
    # The user's own reasons precede.
    groups = replace(read.groups, allowed_collisions={**allowed, **read.groups.allowed_collisions})
    if as_json:
        console.out_json(_document(groups))
        return 0
    text = write_srdf(groups, read.description)
    if output is None:
        console.out_text(text.rstrip("\n"))
    else:
        Path(output).write_text(text, encoding="utf-8")
        console.out_lines(_summary(groups))
        console.out(output)
    return 0


def _summary(groups: "RobotGroups") -> "Iterator[str]":
    for group in groups.groups.values():
        moved = f", moves '{group.tip}'" if group.tip else ""
        states = groups.states.get(group.name, {})
        named = f"; states {', '.join(states)}" if states else ""
        yield f"group '{group.name}': {len(group.joints)} joints{moved}{named}"
    for effector in groups.end_effectors.values():
        where = f"group '{effector.group}' on '{effector.parent_link}'"
        yield f"end effector '{effector.name}': {where}"
    counts: dict[str, int] = {}
    for reason in groups.allowed_collisions.values():
        counts[reason] = counts.get(reason, 0) + 1
    counted = ", ".join(f"{count} {reason}" for reason, count in sorted(counts.items()))
    yield f"pairs of links that may touch: {counted or 'none'}"


def _document(groups: "RobotGroups") -> dict[str, console.Json]:
    return {
        "robot": groups.robot,
        "groups": {
            group.name: {
                "joints": list(group.joints),
                "base": group.base,
                "tip": group.tip or None,
                "tool": None
                if group.tool is None
                else {
                    "position": list(group.tool.translation),
                    "orientation": list(group.tool.rotation),
                },
                "task": group.task or None,
            }
            for group in groups.groups.values()
        },
        "states": {
            group: {name: dict(positions) for name, positions in states.items()}
            for group, states in groups.states.items()
        },
        "end_effectors": {
            effector.name: {
                "group": effector.group,
                "parent_link": effector.parent_link,
                "parent_group": effector.parent_group or None,
            }
            for effector in groups.end_effectors.values()
        },
        "passive_joints": sorted(groups.passive_joints),
        "allowed_collisions": [
            {"link1": first, "link2": second, "reason": reason}
            for (first, second), reason in groups.allowed_collisions.items()
        ],
    }
