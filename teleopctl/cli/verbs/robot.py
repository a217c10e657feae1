"""``teleopctl robot``: checks of robot descriptions and worlds."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import NotFoundError, TeleopctlError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from teleopctl.nodes.robot_check.report import RobotReport


GROUP = VerbGroup(
    "Check robots' files.",
    {
        "check": Verb(
            f"{__name__}:check",
            "Check how robot files are read, and whether the robots stand and move in simulation.",
            examples=(
                "teleopctl robot check my_robot.urdf.xacro",
                "teleopctl robot check ur.urdf.xacro ur_type:=ur5e name:=ur --simulate",
                "teleopctl robot check src --simulate",
            ),
        )
    },
)


_SIMULATED_S = 5.0
# Frames that differ by more are reported; two computations of the same pose differ by much less.
_SAME_M = 1e-6
_TITLES = {
    "repaired": "Repaired",
    "guessed": "Guessed or left out",
    "without_effect": "Without effect",
    "unknown": "Unknown",
}


def check(
    words: Annotated[
        list[str],
        Argument(
            help="Files or folders; a xacro file's arguments as name:=value, and controllers_file, "
            "controllers, controllers_namespace and fixed_base as sim.yaml takes them.",
            metavar="FILE [name:=value]…",
            complete="files",
        ),
    ],
    simulate: Annotated[
        bool,
        Option(
            "-s",
            "--simulate",
            help="Simulate each robot for 5 s at rest, then move it by its controllers.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Check how robot descriptions are read and, with ``simulate``, whether the robots move.

    The first lines are those of check_urdf. For several files, or folders of robots, a table is
    printed. In simulation a robot has the controllers that sim.yaml would start; each of them
    commands a motion, which is measured. The exit status is 1 if a robot fails.
    """
    import tempfile

    from teleopctl.launch import chosen_controllers
    from teleopctl.nodes.robot_check.report import check_robot, defect_report, robots_in

    arguments = dict(word.split(":=", 1) for word in words if ":=" in word)
    places = [Path(word) for word in words if ":=" not in word]
    if not places:
        raise UsageError("No file is given", hint="teleopctl robot check FILE_OR_FOLDER")
    for place in places:
        if not place.exists():
            raise NotFoundError(f"There is no file or folder {place}")
    is_one_file = len(places) == 1 and places[0].is_file()
    with tempfile.TemporaryDirectory() as folder:

        def report_of(file: Path) -> "RobotReport":
            return check_robot(
                file,
                arguments,
                simulate_s=_SIMULATED_S if simulate else 0.0,
                compare_readers=as_json or is_one_file,
                choose=lambda model, given: chosen_controllers(model, given, Path(folder)),
            )

        if is_one_file:
            report = report_of(places[0])
            if as_json:
                console.out_json(_document(report))
            else:
                _print(report)
            return int(bool(report.fault))
        reports = []
        for file in robots_in(places):
            console.note(f"{file}")
            try:
                reports.append(report_of(file))
            except (TeleopctlError, OSError):
                raise
            except Exception as error:  # noqa: BLE001 -- the reports on other files still follow
                reports.append(defect_report(file, error))
    if as_json:
        console.out_json([_document(report) for report in reports])
    else:
        console.out_lines(_table(reports))
    return int(not reports or any(report.fault for report in reports))


def _print(report: "RobotReport") -> None:
    description = report.description
    if report.error is None and report.kind == "world":
        console.out_lines(_of_world(report))
        return
    if report.error is not None or description is None:
        console.note(f"ERROR: Model Parsing the {report.kind} failed: {report.error}")
        return
    console.out(f"robot name is: {description.name}")
    console.out("---------- Successfully Parsed XML ---------------")
    children = description.child_joints[description.root]
    console.out(f"root Link: {description.root} has {len(children)} child(ren)")
    console.out_lines(_tree(report, description.root, 2))
    console.out()
    console.out_lines(_summary(report))


def _of_world(report: "RobotReport") -> "Iterator[str]":
    yield f"world name is: {report.world}"
    moving = sum(report.things.values())
    count = len(report.things)
    counted = f"{count} thing{'s' if count != 1 else ''}, {moving} moving freely"
    yield f"{counted}: {', '.join(report.things)}" if count else counted
    yield from _told(report)
    yield f"It compiles; sim.yaml world:={report.file} puts a robot into it"


def _told(report: "RobotReport") -> "Iterator[str]":
    for attribute, title in _TITLES.items():
        sentences = getattr(report, attribute)
        if sentences:
            yield f"{title}:"
            yield from (f"  {sentence}" for sentence in sentences)


def _tree(report: "RobotReport", link: str, level: int) -> "Iterator[str]":
    """Yield the lines of a link's tree, indented and sorted as by check_urdf."""
    assert report.description is not None
    below = report.description.child_joints
    # Not recursive: a chain of links may exceed Python's recursion limit.
    waiting = [(0, link, level)]
    while waiting:
        number, link, level = waiting.pop()
        if number:
            yield f"{'  ' * level}child({number}):  {link}"
            level += 2
        joints = sorted(below[link], key=lambda joint: joint.name)
        numbered = [(count, joint.child, level) for count, joint in enumerate(joints, 1)]
        waiting += reversed(numbered)


def _summary(report: "RobotReport") -> "Iterator[str]":
    description = report.description
    assert description is not None
    kinds: dict[str, int] = {}
    for joint in description.joints.values():
        kinds[joint.type] = kinds.get(joint.type, 0) + 1
    counted = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    yield f"{len(description.links)} links, {len(description.joints)} joints ({counted or 'none'})"
    if report.mass_kg is not None:
        yield f"Mass: {report.mass_kg:g} kg"
    for package, folder in report.packages.items():
        yield f"Package {package}: {folder or 'not found'}"
    if report.meshes:
        missing = [uri for uri, path in report.meshes.items() if path is None]
        yield f"Meshes: {len(report.meshes) - len(missing)} of {len(report.meshes)} found"
        yield from (f"  not found: {uri}" for uri in missing)
    for system in description.ros2_control:
        yield f"<ros2_control> {system.name} ({system.hardware_plugin_name}):"
        for part in system.joints:
            commands = ", ".join(one.name for one in part.command_interfaces) or "none"
            states = ", ".join(one.name for one in part.state_interfaces) or "none"
            yield f"  {part.name}: commands {commands}; states {states}"
    for name, kind in report.controllers.items():
        yield f"Controller {name}: {kind}"
    yield from _told(report)
    yield from _by_yourdfpy(report)
    if report.refusal is not None:
        yield f"Not simulated: {report.refusal}"
    elif report.trial is None:
        yield "It compiles; --simulate lets the robot stand for 5 s, then moves it"
    else:
        yield from _outcome(report)


def _by_yourdfpy(report: "RobotReport") -> "Iterator[str]":
    read = report.second_reading
    if read is None:
        return
    if read.error:
        yield f"yourdfpy does not read it: {read.error}"
    elif read.differences:
        yield "yourdfpy reads it differently:"
        yield from (f"  {difference.sentence}" for difference in read.differences)
    else:
        yield read.summary


def _outcome(report: "RobotReport") -> "Iterator[str]":
    trial = report.trial
    assert trial is not None
    yield f"In simulation it {trial.verdict}" + (f": {trial.fault}" if trial.fault else "")
    count = len(trial.moved) + len(trial.unmoved)
    if count:
        yield f"{len(trial.moved)} of {count} joints follow a command"
    if trial.unmoved:
        yield f"  not: {', '.join(trial.unmoved)}"
    if trial.blocked:
        yield f"  not tested, both directions meet the ground or a link: {', '.join(trial.blocked)}"
    if trial.travelled_m is not None:
        yield f"Its root link moved {trial.travelled_m:.3f} m during the trial"
    yield from _motions(report)
    if (frames := report.frames) is not None:
        shown = frames.links - len(frames.missing)
        yield f"{shown} of {frames.links} links have a frame on /tf in simulation"
        if frames.missing:
            yield f"  not: {', '.join(frames.missing)}"
        if frames.apart_m > _SAME_M:
            yield f"  physics has one elsewhere, by {frames.apart_m:.2g} m"


def _motions(report: "RobotReport") -> "Iterator[str]":
    driven = report.driven
    if driven is None:
        return
    whose = "its own controllers" if driven.own else "controllers that any robot gets"
    yield f"By {whose}:" + (f" {driven.fault}" if driven.fault else "")
    for motion in driven.motions:
        yield f"  {motion.controller} ({motion.type}): {motion.result}"
    for name, why in driven.inactive.items():
        yield f"  {name} stays inactive: {why}"


_COLUMN_TITLES = ("FILE", "PARSES", "COMPILES", "STANDS", "MOVES", "BY", "FRAMES", "WHY NOT")


def _table(reports: "Sequence[RobotReport]") -> "Iterator[str]":
    """Yield a table with a line per robot, and totals.

    Args:
        reports: Reports on the robots.
    """
    rows = [_COLUMN_TITLES, *(_row(report) for report in reports)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_COLUMN_TITLES) - 1)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        yield "  ".join([*cells, row[-1]]).rstrip()
    own = [row for row in rows if row[5] == "own"]
    if any(report.trial for report in reports):
        complete = sum(1 for report in reports if report.frames and not report.frames.missing)
        yield (
            f"{_yes(rows, 1)} parse, {_yes(rows, 2)} compile, {_yes(rows, 3)} stand, "
            f"{_yes(own, 4)} of {len(own)} with controllers of their own move by them, "
            f"{complete} have every frame"
        )
    failed = sum(1 for report in reports if report.fault)
    yield f"{len(reports) - failed} of {len(reports)} robots are fine"


def _yes(rows: "Sequence[tuple[str, ...]]", column: int) -> int:
    return sum(row[column] == "yes" for row in rows)


def _row(report: "RobotReport") -> tuple[str, ...]:
    trial, driven, frames = report.trial, report.driven, report.frames
    return (
        str(report.file),
        "no" if report.error else "yes",
        "-" if report.error else "no" if report.refusal else "yes",
        "-" if trial is None else "yes" if trial.verdict == "stands" else trial.verdict,
        "-" if driven is None else driven.verdict,
        "-" if driven is None else "own" if driven.own else "made",
        "-" if frames is None else f"{frames.links - len(frames.missing)}/{frames.links}",
        report.fault,
    )


_SENTENCES = ("repaired", "guessed", "without_effect", "unknown")


def _document(report: "RobotReport") -> console.Json:
    """Return a robot's report as JSON; see docs/json.md."""
    description, second = report.description, report.second_reading
    trial, driven, frames = report.trial, report.driven, report.frames
    return {
        "file": str(report.file),
        "kind": report.kind,
        "error": report.error,
        "refusal": report.refusal,
        "fault": report.fault or None,
        "name": report.world or None if description is None else description.name,
        "root": None if description is None else description.root,
        "links": list(report.things if description is None else description.links),
        "joints": []
        if description is None
        else [
            {"name": one.name, "type": one.type, "parent": one.parent, "child": one.child}
            for one in description.joints.values()
        ],
        "mass_kg": report.mass_kg,
        "packages": report.packages,
        "meshes": report.meshes,
        "systems": []
        if description is None or report.error
        else [
            {
                "name": system.name,
                "plugin": system.hardware_plugin_name,
                "joints": [
                    {
                        "name": joint.name,
                        "command_interfaces": [one.name for one in joint.command_interfaces],
                        "state_interfaces": [one.name for one in joint.state_interfaces],
                    }
                    for joint in system.joints
                ],
            }
            for system in description.ros2_control
        ],
        "controllers": report.controllers,
        **{attribute: getattr(report, attribute) for attribute in _SENTENCES},
        "second_reading": None
        if second is None
        else {
            "error": second.error or None,
            "differences": [difference._asdict() for difference in second.differences],
            "meshes": second.meshes,
            "capsules": second.capsules,
        },
        "trial": None
        if trial is None
        else {
            "verdict": trial.verdict,
            "fault": trial.fault or None,
            "moved": list(trial.moved),
            "unmoved": list(trial.unmoved),
            "blocked": list(trial.blocked),
            "travelled_m": trial.travelled_m,
        },
        "driven": None
        if driven is None
        else {
            "own": driven.own,
            "verdict": driven.verdict,
            "fault": driven.why_not or None,
            "motions": [motion._asdict() for motion in driven.motions],
            "inactive": driven.inactive,
        },
        "frames": None if frames is None else frames._asdict(),
    }
