"""``teleopctl move``: moves an arm to a pose, to joint positions or to a named state."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb
from teleopctl.cli.verbs.kinematics.source import RobotOptions
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.cli.verbs.move.planning import PlannedMotion

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
    """Plan a motion that touches nothing, and execute it by the active trajectory controllers.

    A position without a rotation leaves the rotation free; with --linear it keeps the present one.
    Where a move_group runs, it plans and executes, with its scene. Ctrl-C stops the arm.
    """
    from teleopctl.cli.verbs.move.planning import Goal

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
    _check_plot(plot, output)
    goal = Goal(to, rpy, quat, frame, linear, joints, named, speed, acceleration, planner, timeout)
    from teleopctl.cli.verbs.move.motion import MotionRun

    with MotionRun.of(robot, direct=direct) as run:
        opening = None if gripper is None else run.opening(gripper)
        planned = run.plan(goal) if goals else None
        if planned is not None:
            if not as_json:
                console.note(planned.summary)
                for note in planned.notes:
                    console.note(note)
            if plot:
                _plot(planned, output)
        elif plot:
            raise UsageError("--plot draws the motion of an arm, and only the gripper is moved")
        if dry_run:
            if as_json:
                console.out_json({"planned": _document(planned, with_points=True), "executed": []})
            return 0
        outcomes = []
        if planned is not None:
            outcomes.append(run.execute(planned, shows_progress=not as_json))
        if opening is not None and all(outcome.succeeded for outcome in outcomes):
            outcomes.append(run.move_gripper(opening))
    if as_json:
        console.out_json(
            {
                "planned": _document(planned, with_points=False),
                "executed": [outcome.document() for outcome in outcomes],
            }
        )
    else:
        for outcome in outcomes:
            (console.out if outcome.succeeded else console.note)(outcome.text)
    return next((outcome.status for outcome in outcomes if not outcome.succeeded), 0)


def _document(planned: "PlannedMotion | None", *, with_points: bool) -> console.Json:
    return None if planned is None else planned.document(with_points=with_points)


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
            quantity: planned.curves(quantity)
            for quantity in ("positions", "velocities", "accelerations")
        }
        save_panels(panels, Path(output), f"Planned motion of {planned.duration_s:.2f} s")
        console.note(f"Written: {output}")
        return
    import shutil
    import sys

    from teleopctl.cli.verbs.topic.plot import MOST_TRACES, line_plot_text, reduced_points

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 80
    last_s = max(planned.duration_s, 1e-3)
    lines = [
        (
            curve.name,
            *reduced_points(list(zip(curve.times, curve.values, strict=True)), 0.0, last_s, width),
        )
        for curve in planned.curves("positions")[:MOST_TRACES]
    ]
    colour = sys.stdout.isatty() and console.colour_enabled(sys.stdout)
    console.out_drawing(line_plot_text(lines, (0.0, last_s), width, 16, colour=colour))
