"""``teleopctl move``: moves an arm to a pose, to joint positions or to a named state."""

import contextlib
import math
import sys
from pathlib import Path
from typing import NamedTuple

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb
from teleopctl.cli.verbs.kinematics.source import (
    RobotOptions,
    numbers,
    render_nothing,
    sorted_words,
)
from teleopctl.errors import EXIT_INTERRUPTED, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Self

    from teleopctl.bag import Curve
    from teleopctl.commander import MotionResult, PlannedMotion, RunningArm
    from teleopctl.kinematics import Arm

# Longest time for the node's thread to end, s.
_THREAD_S = 1.0

VERB = Verb(
    f"{__name__}:move",
    "Move an arm, or its gripper.",
    examples=(
        "teleopctl move --to 0.3,0,0.4 --rpy 3.14,0,0",
        "teleopctl move --to 0,0,0.05 --frame tool0 --linear --speed 0.2",
        "teleopctl move --joints joint_1=0.5,joint_2=-0.3",
        "teleopctl move --named home --gripper open",
        "teleopctl move --to 0.3,0,0.4 --dry-run --plot",
    ),
)


def move(
    to: Annotated[
        str | None, Option("--to", help="Position of the tool in m.", metavar="X,Y,Z")
    ] = None,
    rpy: Annotated[
        str | None,
        Option("--rpy", help="Rotation of the tool: roll, pitch, yaw in rad.", metavar="R,P,Y"),
    ] = None,
    quat: Annotated[
        str | None,
        Option("--quat", help="Rotation of the tool as a quaternion.", metavar="X,Y,Z,W"),
    ] = None,
    frame: Annotated[
        str | None,
        Option(
            "-f",
            "--frame",
            help="Link, or frame of /tf, in which the pose is; by default the root link.",
            metavar="FRAME",
            complete="all_links",
        ),
    ] = None,
    linear: Annotated[bool, Option("--linear", help="Move the tool on a straight line.")] = False,
    joints: Annotated[
        str | None,
        Option(
            "--joints",
            help="Positions of joints in rad or m, in the group's order or by name.",
            metavar="POSITIONS",
        ),
    ] = None,
    named: Annotated[
        str | None,
        Option(
            "--named", help="Named state of the group.", metavar="STATE", complete="named_states"
        ),
    ] = None,
    gripper: Annotated[
        str | None,
        Option(
            "--gripper",
            help="open, close, or a number from 0 (closed) to 1 (open); after the arm.",
            metavar="OPENING",
        ),
    ] = None,
    speed: Annotated[
        float,
        Option("--speed", help="Part of the velocity limits, above 0 to 1.", metavar="FACTOR"),
    ] = 1.0,
    acceleration: Annotated[
        float,
        Option(
            "--acceleration",
            help="Part of the acceleration limits, above 0 to 1.",
            metavar="FACTOR",
        ),
    ] = 1.0,
    planner: Annotated[
        str,
        Option("--planner", help="Planner, by OMPL's names, such as RRTstar.", metavar="PLANNER"),
    ] = "",
    timeout: Annotated[
        float, Option("--timeout", help="Longest time to plan.", metavar="SECONDS")
    ] = 5.0,
    dry_run: Annotated[bool, Option("--dry-run", help="Plan, and move nothing.")] = False,
    plot: Annotated[
        bool, Option("--plot", help="Draw the joints' positions over the planned time.")
    ] = False,
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="With --plot: write a picture instead, PNG, SVG or PDF by the file name.",
            metavar="FILE",
        ),
    ] = None,
    direct: Annotated[
        bool,
        Option("--direct", help="Plan in this process even if move_group runs."),
    ] = False,
    *,
    robot: RobotOptions,
    as_json: AsJson = False,
) -> int:
    """Plan a collision-free motion, and execute it by the active trajectory controllers.

    A position without a rotation leaves the rotation free; with --linear it keeps the present one.
    Where a move_group runs, it plans and executes, with its scene. Ctrl-C stops the arm.
    """
    goals = [
        name for name, value in (("--to", to), ("--joints", joints), ("--named", named)) if value
    ]
    if len(goals) > 1:
        raise UsageError(f"Give one goal, not {' and '.join(goals)}")
    if not goals and gripper is None:
        raise UsageError(
            "Give a goal: --to X,Y,Z, --joints POSITIONS, --named STATE or --gripper OPENING",
            hint="teleopctl move --help",
        )
    if to is None and (rpy or quat or frame or linear):
        raise UsageError("--rpy, --quat, --frame and --linear belong to --to")
    for name, value in (("--speed", speed), ("--acceleration", acceleration)):
        if not 0.0 < value <= 1.0:
            raise UsageError(f"{name} is a factor above 0 and at most 1, got {value:g}")
    if not timeout > 0.0:
        raise UsageError(f"--timeout must be above 0 s, got {timeout:g}")
    if output is not None and not plot:
        raise UsageError("-o writes the picture of --plot")
    if plot and not goals:
        raise UsageError("--plot draws the motion of an arm, and only the gripper is moved")
    _check_plot(plot, output)
    if rpy is not None and quat is not None:
        raise UsageError("Give --rpy or --quat, not both")
    render_nothing()
    with _arm(robot, direct=direct) as arm:
        for warning in arm.warnings:
            console.warn(warning)
        opening = None if gripper is None else _opening(gripper, arm.arm)
        planned = None
        if goals:
            planned = arm.plan(
                to=None if to is None else numbers(to, 3, "--to", "x,y,z"),
                rpy=None if rpy is None else numbers(rpy, 3, "--rpy", "roll,pitch,yaw"),
                quat=None if quat is None else numbers(quat, 4, "--quat", "x,y,z,w"),
                frame=frame,
                linear=linear,
                joints=None if joints is None else _positions(joints),
                named=named,
                speed=speed,
                acceleration=acceleration,
                planner=planner,
                timeout_s=timeout,
            )
            if not as_json:
                console.note(planned.summary)
                for note in planned.notes:
                    console.note(note)
            if plot:
                _plot(planned, output)
        document = None if planned is None else _document(planned, with_points=dry_run)
        if dry_run:
            if as_json:
                console.out_json({"planned": document, "executed": []})
            return 0
        outcomes = []
        if planned is not None:
            motion = planned
            with _Progress(is_shown=not as_json) as progress:
                outcomes.append(_outcome(lambda: arm.execute(motion, progress.show), arm))
        if opening is not None and all(outcome.status == 0 for outcome in outcomes):
            part = opening
            outcomes.append(_outcome(lambda: arm.gripper(part), arm))
    if as_json:
        executed = [outcome.document() for outcome in outcomes]
        console.out_json({"planned": document, "executed": executed})
    else:
        for outcome in outcomes:
            (console.note if outcome.status else console.out)(outcome.text)
    return next((outcome.status for outcome in outcomes if outcome.status), 0)


# --- input --------------------------------------------------------------------------------------


@contextlib.contextmanager
def _arm(options: RobotOptions, *, direct: bool) -> "Iterator[RunningArm]":
    """Yield the arm, with a hidden node of its own."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.commander import RunningArm
    from teleopctl.node import SingleThreadedExecutor, spin_in_thread

    namespace = options.namespace.strip("/")
    ros_args = ["-r", f"__ns:=/{namespace}"] if namespace else []
    with command_node(ros_args=ros_args) as node:
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        thread = spin_in_thread(executor)
        try:
            yield RunningArm(
                options.group or "",
                options.tool_frame(),
                srdf=options.srdf,
                direct=direct,
                node=node,
            )
        finally:
            executor.shutdown()
            thread.join(_THREAD_S)


def _positions(text: str) -> dict[str, float] | list[float]:
    words = sorted_words(text.replace(",", " ").split())
    if words.names or words.file or (words.numbers and words.joints):
        raise UsageError(f"--joints takes numbers or JOINT=POSITION, with commas; got '{text}'")
    return words.joints or words.numbers


def _opening(text: str, arm: "Arm") -> float:
    """Return the opening of a gripper, from 0 to 1, before anything moves."""
    from teleopctl.commander import gripper_positions, opening_part

    try:
        part = opening_part(text)
    except UsageError:
        raise UsageError(
            f"--gripper is open, close or a number from 0 (closed) to 1 (open), not '{text}'"
        ) from None
    gripper_positions(arm.model, arm.groups, arm.group.name, part)
    return part


# --- output -------------------------------------------------------------------------------------


class _Outcome(NamedTuple):
    """End of a motion: what happened, the exit status, and facts for JSON."""

    text: str
    status: int
    facts: dict[str, console.Json]

    def document(self) -> dict[str, console.Json]:
        """Return the end for JSON."""
        word = {0: "succeeded", EXIT_INTERRUPTED: "stopped"}.get(self.status, "failed")
        return {"result": word, "message": self.text, **self.facts}


def _outcome(run: "Callable[[], MotionResult]", arm: "RunningArm") -> _Outcome:
    """Return how a motion ended: at its goal, before it, or by Ctrl-C."""
    from teleopctl.commander import ExecutionError

    try:
        result = run()
    except ExecutionError as error:
        code: dict[str, console.Json] = {"error_code": error.code} if error.code else {}
        return _Outcome(error.message, 1, {**_facts(error.result), **code})
    except KeyboardInterrupt as error:
        notes = "".join(f"; {note}" for note in getattr(error, "__notes__", ()))
        joints: dict[str, console.Json] = dict(arm.positions)
        return _Outcome(f"Stopped by Ctrl-C{notes}", EXIT_INTERRUPTED, {"joints": joints})
    return _Outcome(result.text, 0, _facts(result))


def _facts(result: "MotionResult") -> dict[str, console.Json]:
    facts: dict[str, console.Json] = {"time_s": result.time_s, "joints": dict(result.joints)}
    if result.position is not None:
        facts["position"] = dict(zip("xyz", result.position, strict=True))
    for name in ("position_error_m", "rotation_error_rad", "largest_joint_error"):
        if (value := getattr(result, name)) is not None:
            facts[name] = value
    return facts


class _Progress:
    """Line on the terminal with the part of the way that is done, while a block runs.

    Args:
        is_shown: Whether to show it, on a terminal.
    """

    def __init__(self, *, is_shown: bool) -> None:
        self._is_shown = is_shown and sys.stderr.isatty()
        self._text = ""

    def __enter__(self) -> "Self":
        return self

    def __exit__(self, *_: object) -> None:
        if self._text:
            sys.stderr.write(f"\r{'':14}\r")
            sys.stderr.flush()

    def show(self, part: float) -> None:
        """Show a part, 0 to 1."""
        text = f"Moving: {100.0 * part:.0f} %"
        if self._is_shown and text != self._text:
            self._text = text
            sys.stderr.write(f"\r{text:14}")
            sys.stderr.flush()


def _document(planned: "PlannedMotion", *, with_points: bool) -> dict[str, console.Json]:
    """Return a planned motion for JSON.

    Args:
        planned: The motion.
        with_points: Whether to add the points of the trajectory.
    """
    from teleopctl.interfaces import to_nanoseconds

    document: dict[str, console.Json] = {
        "planner": planned.planner,
        "computing_s": planned.computing_s,
        "duration_s": planned.duration_s,
        "joint_names": list(planned.trajectory.joint_names),
        "notes": list(planned.notes),
    }
    if with_points:
        document["points"] = [
            {
                "time_s": 1e-9 * to_nanoseconds(point.time_from_start),
                "positions": list(map(float, point.positions)),
                "velocities": list(map(float, point.velocities)),
                "accelerations": list(map(float, point.accelerations)),
            }
            for point in planned.trajectory.points
        ]
    return document


def _check_plot(plot: bool, output: str | None) -> None:
    if output is not None:
        from teleopctl.bag import check_plot_file

        check_plot_file(Path(output))
    elif plot:
        from teleopctl.base.extras import extra

        with extra("tui", "uniplot"):
            import uniplot as uniplot


def _plot(planned: "PlannedMotion", output: str | None) -> None:
    """Draw the planned positions, or write them as a picture with velocities and accelerations."""
    if output is not None:
        from teleopctl.bag import save_panels

        panels = {
            quantity: _curves(planned, quantity)
            for quantity in ("positions", "velocities", "accelerations")
        }
        save_panels(panels, Path(output), f"Planned motion of {planned.duration_s:.2f} s")
        console.note(f"Written: {output}")
        return
    import shutil

    from teleopctl.cli.verbs.topic.plot import MOST_TRACES, line_plot_text, reduced_points

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 80
    last_s = max(planned.duration_s, 1e-3)
    lines = [
        (
            curve.name,
            *reduced_points(list(zip(curve.times, curve.values, strict=True)), 0.0, last_s, width),
        )
        for curve in _curves(planned, "positions")[:MOST_TRACES]
    ]
    colour = sys.stdout.isatty() and console.colour_enabled(sys.stdout)
    console.out_drawing(line_plot_text(lines, (0.0, last_s), width, 16, colour=colour))


def _curves(planned: "PlannedMotion", quantity: str) -> "list[Curve]":
    """Return ``positions``, ``velocities`` or ``accelerations`` of each joint over time."""
    from teleopctl.bag import Curve
    from teleopctl.interfaces import to_nanoseconds

    points = planned.trajectory.points
    times = [1e-9 * to_nanoseconds(point.time_from_start) for point in points]
    rows = [getattr(point, quantity) for point in points]
    return [
        Curve(name, times, [float(row[place]) if place < len(row) else math.nan for row in rows])
        for place, name in enumerate(planned.trajectory.joint_names)
    ]
