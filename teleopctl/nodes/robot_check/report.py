"""Report on a robot file: how it was read, what was repaired, and how it moves in simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lxml import etree

from teleopctl.errors import TeleopctlError
from teleopctl.nodes.robot_check.stability import (
    CONTROL_PERIOD_NS,
    StabilityReport,
    check_stability,
)
from teleopctl.packages import package_share, resolve_uri
from teleopctl.robot import (
    Mesh,
    RobotDescription,
    arguments_text,
    controller_parameter_files,
    is_world,
    model_kind,
    read_model,
    read_world,
    simulated,
    unknown_tags,
    with_absolute_mesh_paths,
    with_source_places,
    xacro_arguments,
)

if TYPE_CHECKING:
    from teleopctl.nodes.robot_check.controllers import ControllerReport
    from teleopctl.nodes.robot_check.frames import FrameComparison
    from teleopctl.nodes.robot_check.second_reading import SecondReading
    from teleopctl.robot import ChosenControllers
    from teleopctl.sim import SimulatedRobot

_SUFFIXES = (".urdf", ".xacro", ".xml", ".sdf")
# Root elements of robot files; macros have the root of a robot too, but no links.
_ROOTS = ("robot", "mujoco", "sdf")
_XACRO = "{http://www.ros.org/wiki/xacro}"
_MACROS = frozenset(f"{_XACRO}{tag}" for tag in ("macro", "property", "arg"))


def robots_in(paths: Iterable[Path]) -> Iterator[Path]:
    """Yield the given files, and robot files in given folders that no other file includes.

    Xacro files without a robot name, and files that an MJCF file includes, are parts of others.

    Args:
        paths: Files, yielded whatever their content, and folders.
    """
    for path in paths:
        if path.is_file():
            yield path
            continue
        files = [file for file in sorted(path.rglob("*")) if file.suffix in _SUFFIXES]
        roots = {file: root for file in files if (root := _root(file)) is not None}
        included = {
            (file.parent / (element.get("file") or "")).resolve()
            for file, root in roots.items()
            for element in root.iter("include")
        }
        for file, root in roots.items():
            if file.resolve() not in included and _is_robot(root):
                yield file


def _root(file: Path) -> etree._Element | None:
    parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)
    try:
        root = etree.parse(str(file), parser).getroot()
    except (OSError, etree.XMLSyntaxError):
        return None
    return root if root.tag in _ROOTS else None


def _is_robot(root: etree._Element) -> bool:
    if root.tag == "robot":
        has_parts = any(str(child.tag) not in _MACROS for child in root)
        return bool(root.get("name")) and has_parts
    if root.tag == "sdf":
        return root.find("model") is not None
    return root.find(".//body") is not None or root.find("include") is not None


# Called with the path of the robot's file and all arguments.
ChooseControllers = Callable[[Path, Mapping[str, str]], "ChosenControllers | None"]

# Arguments of sim.yaml, which are not arguments of the description.
_OF_THE_LAUNCH = ("controllers", "controllers_file", "controllers_namespace", "fixed_base")
_PARAMETERS = "ros__parameters"
_PACKAGE = "package://"


@dataclass
class RobotReport:
    """Report on a robot file: errors, repairs, model, simulation, controllers and frames.

    Attributes:
        file: Path of the robot file.
        kind: ``urdf``, ``sdf`` or ``mjcf``; ``world`` for a world without a robot.
        error: Reason why the file is not a valid robot; None if it is valid.
        refusal: Reason why the robot cannot be simulated; None if it can.
        description: Parsed robot description; None if the file is not valid.
        mass_kg: Mass of the whole robot, as simulated.
        repaired: Corrections of the text, a sentence each.
        guessed: Values that were assumed, and parts left out, a sentence each.
        without_effect: Unsupported parts of the description, a sentence each.
        unknown: Unknown elements and attributes, a sentence each.
        packages: Folders of the packages in the description; None for a package that is not found.
        meshes: Files of the meshes by URI; None for a mesh that is not found.
        controllers: Types by name of the controllers in the description's parameter files.
        second_reading: Comparison with yourdfpy's model, if requested.
        trial: Result of the simulation without controllers, if requested.
        driven: Result of the test of the controllers, if requested and the robot has any.
        frames: Comparison of the robot's frames, if simulation was requested.
        places: Source file and line of each line of the text, where it is not that file's.
        things: Objects of a world by name, and whether each moves freely.
        world: Name of a world.
    """

    file: Path
    kind: str
    error: str | None = None
    refusal: str | None = None
    description: RobotDescription | None = None
    mass_kg: float | None = None
    repaired: list[str] = field(default_factory=list)
    guessed: list[str] = field(default_factory=list)
    without_effect: list[str] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)
    packages: dict[str, str | None] = field(default_factory=dict)
    meshes: dict[str, str | None] = field(default_factory=dict)
    controllers: dict[str, str] = field(default_factory=dict)
    second_reading: SecondReading | None = None
    trial: StabilityReport | None = None
    driven: ControllerReport | None = None
    frames: FrameComparison | None = None
    places: Mapping[int, tuple[Path, int]] = field(default_factory=dict)
    things: dict[str, bool] = field(default_factory=dict)
    world: str = ""

    @property
    def fault(self) -> str:
        """First problem with the file or the robot, as text; empty if there is none."""
        if self.error or self.refusal:
            return self.error or self.refusal or ""
        missing = [uri for uri, path in self.meshes.items() if path is None]
        if missing:
            more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            return f"no file for the mesh {missing[0]}{more}"
        if self.trial is not None and self.trial.fault:
            return self.trial.fault
        if self.driven is not None and self.driven.why_not:
            return self.driven.why_not
        if self.frames is not None and self.frames.missing:
            return f"no frame for {', '.join(self.frames.missing)}: its joint has no state"
        return ""


def check_robot(
    file: Path,
    arguments: Mapping[str, str],
    *,
    simulate_s: float = 0.0,
    compare_readers: bool = True,
    choose: ChooseControllers = lambda *_: None,
) -> RobotReport:
    """Read a robot file, build its model, simulate it if requested; return a `RobotReport`.

    Args:
        file: Path of a URDF, xacro, SDF or MJCF file.
        arguments: Values of the xacro file's arguments, and of the arguments of ``sim.yaml`` that
            choose the controllers and whether the root link is fixed.
        simulate_s: Simulated seconds for which the robot has to stand; 0 for no simulation.
        compare_readers: Whether to read the file with yourdfpy too, which takes time for its import
            and the meshes.
        choose: Function that returns the robot's controllers; None for a robot without controllers.

    Returns:
        Report, which includes errors of the file.
    """
    report = RobotReport(file, model_kind(file))
    if is_world(file):
        return _of_world(RobotReport(file, "world"))
    own = {name: value for name, value in arguments.items() if name not in _OF_THE_LAUNCH}
    try:
        read = read_model(file, own, places=True)
        report.places = read.places
        taken = xacro_arguments(read.files) if own else {}
        text = with_absolute_mesh_paths(read.text, file.absolute().parent)
        try:
            report.description = description = RobotDescription.from_urdf(text)
            _check_files(report, description)
            _check_controllers(report, description)
            _ = description.ros2_control  # parsed here, to report its errors as errors of the file
            urdf, remarks = simulated(text)
        except TeleopctlError as error:
            raise error.at(str(file)) from error
    except TeleopctlError as error:
        message = f"{error.message} ({error.hint})" if error.hint else error.message
        report.error = with_source_places(message, report.places)
        return report
    report.repaired = list(description.repairs)
    report.guessed += remarks
    report.unknown = [] if description.mjcf else unknown_tags(text)
    takes = f"it takes {arguments_text(taken)}" if taken else "it takes none"
    report.unknown += [
        f"Argument '{name}' is unknown to the description: {takes}"
        for name in own
        if name not in taken
    ]
    if compare_readers:
        _check_second_reading(report, description)
    try:
        robot = _check_model(report, urdf, arguments.get("fixed_base", "auto"))
    except TeleopctlError as error:
        report.refusal = with_source_places(error.message, report.places)
        return report
    finally:
        for sentences in (report.repaired, report.guessed, report.without_effect, report.unknown):
            sentences[:] = [with_source_places(sentence, report.places) for sentence in sentences]
    if simulate_s:
        report.trial = check_stability(robot, simulate_s)
        _check_motion(report, robot, arguments, choose)
    return report


def defect_report(file: Path, error: Exception) -> RobotReport:
    """Return a report on a robot file whose check raised an unexpected exception."""
    what = f"a defect of teleopctl, {type(error).__name__}: {error}"
    where = f"`teleopctl --debug robot check {file}` shows where"
    return RobotReport(file, model_kind(file), error=f"{what}; {where}")


def _of_world(report: RobotReport) -> RobotReport:
    """Complete and return the report on a world without a robot."""
    from teleopctl.mujoco_model import build_model

    nobody = RobotDescription.from_urdf('<robot name="nobody"><link name="world"/></robot>')
    try:
        world = read_world(report.file)
        model = build_model(nobody, world=world)
    except TeleopctlError as error:
        report.error = f"{error.message} ({error.hint})" if error.hint else error.message
        return report
    report.world = world.name
    report.things = {thing.name: bool(thing.joint) for thing in model.things}
    report.without_effect = list(model.warnings)
    return report


def _check_motion(
    report: RobotReport,
    robot: SimulatedRobot,
    arguments: Mapping[str, str],
    choose: ChooseControllers,
) -> None:
    from teleopctl.nodes.robot_check.controllers import ControllerReport, check_controllers
    from teleopctl.nodes.robot_check.frames import compare_frames

    try:
        controllers = choose(report.file.absolute(), arguments)
    except TeleopctlError as error:
        message = f"{error.message} ({error.hint})" if error.hint else error.message
        report.driven = ControllerReport(own=True, fault=message)
        return
    report.driven = check_controllers(robot, controllers)
    published = set() if report.driven is None else report.driven.joints
    report.frames = compare_frames(robot, published)


def _check_model(report: RobotReport, urdf: str, fixed_base: str) -> SimulatedRobot:
    import mujoco

    from teleopctl.mujoco_model import assumed_rotors_text, gazebo_only_tags, unsupported_tags
    from teleopctl.sim import read_fixed_base, simulate

    assert report.description is not None
    report.without_effect = unsupported_tags(report.description.urdf)
    report.without_effect += gazebo_only_tags(report.description.urdf)
    said = [
        warning
        for part in RobotDescription.from_urdf(urdf).ros2_control
        for warning in part.warnings
    ]
    # Without a handler, MuJoCo writes its warnings to a file in the current folder.
    mujoco.set_mju_user_warning(lambda text: said.append(f"MuJoCo: {' '.join(text.split())}"))
    robot = simulate(
        urdf,
        fixed_base=read_fixed_base(fixed_base),
        control_period_ns=CONTROL_PERIOD_NS,
        warn=said.append,
    )
    m: Any = robot.model.mj_model
    links = robot.description.links
    masses = (float(m.body_mass[n]) for n in range(m.nbody) if m.body(n).name in links)
    report.mass_kg = round(sum(masses), 6)
    known = {*report.repaired, *unsupported_tags(urdf), *unknown_tags(urdf)}
    report.guessed += [sentence for sentence in said if sentence not in known]
    if rotors := robot.model.assumed_rotors():
        report.guessed.append(assumed_rotors_text(rotors))
    return robot


def _check_second_reading(report: RobotReport, description: RobotDescription) -> None:
    from teleopctl.nodes.robot_check.second_reading import read_again

    read = read_again(description)
    report.second_reading = read._replace(
        differences=tuple(
            difference._replace(where=with_source_places(difference.where, report.places))
            for difference in read.differences
        )
    )


def _check_files(report: RobotReport, description: RobotDescription) -> None:
    for uri in dict.fromkeys(_mesh_uris(description)):
        try:
            path = resolve_uri(uri)
            report.meshes[uri] = str(path) if path.is_file() else None
        except (TeleopctlError, OSError):  # OSError: the file name is too long
            report.meshes[uri] = None
        if uri.startswith(_PACKAGE):
            package = uri.removeprefix(_PACKAGE).partition("/")[0]
            report.packages.setdefault(package, _folder_of(package))


def _folder_of(package: str) -> str | None:
    try:
        return str(package_share(package))
    except TeleopctlError:
        return None


def _mesh_uris(description: RobotDescription) -> Iterator[str]:
    for link in description.links.values():
        shapes = [part.geometry for part in link.visuals]
        shapes += [part.geometry for part in link.collisions]
        yield from (shape.uri for shape in shapes if isinstance(shape, Mesh))


def _check_controllers(report: RobotReport, description: RobotDescription) -> None:
    from yaml import YAMLError

    from teleopctl.base.ros_yaml import load_merged

    for path in controller_parameter_files(description):
        try:
            content = load_merged(resolve_uri(path).read_text(encoding="utf-8"))
        except (TeleopctlError, OSError, UnicodeDecodeError, YAMLError) as error:
            report.guessed.append(f"Controllers of {path} are not read: {error}")
            continue
        report.controllers.update(_types_in(content))


# Any: content of a YAML file.
def _types_in(content: Any) -> Iterator[tuple[str, str]]:
    """Yield names and types of controllers in controller managers' parameters at any depth."""
    if not isinstance(content, dict):
        return
    for name, value in content.items():
        if isinstance(value, dict):
            own = value.get(_PARAMETERS)
            types = [part.get("type") for part in (value, own) if isinstance(part, dict)]
            for kind in types if name != _PARAMETERS else ():
                if isinstance(kind, str) and "/" in kind:
                    yield str(name), kind
            yield from _types_in(value)
