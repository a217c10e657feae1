"""Mappings from the axes and buttons of a device to motion and actions, as YAML files.

A file per device and robot. Its names follow ``teleop_twist_joy``::

    device: gamepad
    robot: ""                      # name of a robot, to which the file then applies alone
    axis_linear: {x: left_y, y: left_x, z: right_y}
    scale_linear: {x: 1.0, y: 1.0, z: 1.0}
    enable_button: left_bumper     # without it nothing moves
    enable_turbo_button: ""        # enables, too, at the full speed
    button_linear: {z: [dpad_up, dpad_down]}     # the one for +, the one for -
    axis_angular: {yaw: right_x}
    gripper: {axis: "", open: a, close: b, toggle: x}
    actions: {stop: back, slower: left_bumper, faster: right_bumper, episode_start: start}

A mobile base has files of its own, in the folder ``base`` beside those of arms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from yaml import MappingNode

from teleopctl.base.ros_yaml import compose, faults_of, safe_load
from teleopctl.errors import InvalidFileError, NotFoundError, did_you_mean
from teleopctl.teleop.device import HandSample

FOLDER = Path(__file__).with_name("mappings")
LINEAR, ANGULAR = ("x", "y", "z"), ("roll", "pitch", "yaw")
EPISODE = "episode_"
"""Beginning of the actions for episodes."""
EPISODE_STEPS = ("start", "success", "save", "discard")
"""Actions of the operator on an episode; ``success`` also saves it."""
ACTIONS = (
    *("stop", "release_stop", "slower", "faster", "base", "tip", "take", "engage", "disengage"),
    *(f"{EPISODE}{step}" for step in EPISODE_STEPS),
)
"""Actions of buttons: they begin with the press; ``base`` and ``tip`` choose the twist's axes."""
_FRAMES = ("base", "tip")
_SPEEDS, _SLOW = (0.25, 0.5, 1.0), 0.25
_DEADZONE = 0.1

# Any, here: values of a YAML document.


@dataclass(frozen=True, slots=True)
class HandCommand:
    """Motion command of an operator, as fractions of the robot's speeds, before the speed step.

    Attributes:
        linear: Direction of the tool along x, y, z, each -1 to 1.
        angular: Rotation about x, y, z, each -1 to 1.
        gripper: Speed of the gripper, 1 opens and -1 closes.
        is_slow: Whether the slow button is held.
        is_turbo: Whether the turbo button is held: then the speed is the full one.
        is_held: Whether an input that moves the robot is held.
        actions: Actions whose buttons are pressed now.
        toggles_gripper: Whether the button that opens or closes the gripper is pressed.
        drags: Whether a mouse button or a finger is held in the 3D view, as while a handle is
            dragged.
    """

    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gripper: float = 0.0
    is_slow: bool = False
    is_turbo: bool = False
    is_held: bool = False
    actions: frozenset[str] = frozenset()
    toggles_gripper: bool = False
    drags: bool = False

    def part(self, speed: float) -> float:
        """Return the fraction of the robot's speeds at a speed step, from 0 to 1."""
        full = 1.0 if self.is_turbo else speed
        return full * (_SLOW if self.is_slow else 1.0)

    def __add__(self, other: HandCommand) -> HandCommand:
        """Return the sum of two commands, each direction clipped to 1."""
        return HandCommand(
            _summed(self.linear, other.linear),
            _summed(self.angular, other.angular),
            _clipped(self.gripper + other.gripper),
            self.is_slow or other.is_slow,
            self.is_turbo or other.is_turbo,
            self.is_held or other.is_held,
            self.actions | other.actions,
            self.toggles_gripper or other.toggles_gripper,
            self.drags or other.drags,
        )


@dataclass(frozen=True, slots=True)
class _Direction:
    """Inputs for one direction of motion: an axis with its scale, and a pair of buttons."""

    axis: str = ""
    scale: float = 1.0
    plus: str = ""
    minus: str = ""

    def value(self, sample: HandSample, deadzone: float) -> float:
        found = _beyond(sample.axes.get(self.axis, 0.0), deadzone) if self.axis else 0.0
        pressed = (self.plus in sample.buttons) - (self.minus in sample.buttons)
        return _clipped(self.scale * (found + pressed))


@dataclass(frozen=True, slots=True)
class HandMapping:
    """Mapping from the axes and buttons of a device to commands, for a robot.

    Attributes:
        device: Device for which the mapping is.
        robot: Name of the robot for which it is; empty for any.
        frame: ``base`` for the axes of the root link, ``tip`` for those of the gripper.
        enable_button: Button without which nothing moves; empty for none.
        enable_turbo_button: Button that enables, too, at the full speed; empty for none.
        slow_button: Button that makes the motion a quarter as fast; empty for none.
        speeds: Speed steps, as parts of the robot's speeds.
        deadzone: Part of an axis around its middle that does nothing.
    """

    device: str
    robot: str = ""
    frame: str = "base"
    enable_button: str = ""
    enable_turbo_button: str = ""
    slow_button: str = ""
    speeds: tuple[float, ...] = _SPEEDS
    deadzone: float = _DEADZONE
    _linear: tuple[_Direction, ...] = ()
    _angular: tuple[_Direction, ...] = ()
    _gripper: Mapping[str, str] = field(default_factory=dict)
    _actions: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def load(cls, name: str | Path, robot: str = "", *, is_base: bool = False) -> HandMapping:
        """Read a mapping by its name or path; of a name, that for a robot if there is one.

        Args:
            name: Name of a mapping that comes with teleopctl, or a path of a YAML file.
            robot: Name of the robot that is driven.
            is_base: Whether the robot is a mobile base.

        Raises:
            NotFoundError: There is no such mapping.
            InvalidFileError: The file cannot be read, is no mapping, or is for another robot.
        """
        path = mapping_file(name, robot, FOLDER / "base" if is_base else FOLDER)
        text = read_mapping(path)
        with faults_of(path):
            mapping = _Reader(path, text).mapping(safe_load(text))
        check_robot(path, mapping.robot, robot)
        return mapping

    @classmethod
    def parse(cls, document: Any, path: Path) -> HandMapping:
        """Return the mapping of a YAML document.

        Args:
            document: The document.
            path: File of the document, for errors.

        Raises:
            InvalidFileError: The document is no mapping.
        """
        return _Reader(path).mapping(document)

    def inputs(self) -> frozenset[str]:
        """Return the names of the inputs that it cannot do without.

        They are the axes of the motion, the button that enables it, and the one that stops it.
        """
        axes = {each.axis for each in (*self._linear, *self._angular)}
        return frozenset({*axes, self.enable_button, self._actions.get("stop", "")} - {""})

    def all_inputs(self) -> frozenset[str]:
        """Return the names of all inputs that it uses."""
        directions = (*self._linear, *self._angular)
        pairs = {button for each in directions for button in (each.plus, each.minus)}
        held = {self.enable_turbo_button, self.slow_button}
        others = {*pairs, *held, *self._gripper.values(), *self._actions.values()}
        return self.inputs() | (others - {""})

    def holds(self, sample: HandSample) -> bool:
        """Return whether an enabling button is pressed, or none is needed."""
        enabling = {self.enable_button, self.enable_turbo_button} - {""}
        return not enabling or bool(enabling & sample.buttons)

    def command(self, sample: HandSample) -> HandCommand:
        """Return the command for a sample."""
        pressed = sample.buttons
        turbo = bool(self.enable_turbo_button) and self.enable_turbo_button in pressed
        held = self.holds(sample)
        linear = tuple(each.value(sample, self.deadzone) for each in self._linear)
        angular = tuple(each.value(sample, self.deadzone) for each in self._angular)
        gripper = self._gripper_speed(sample)
        if not held:
            linear = angular = (0.0, 0.0, 0.0)
            gripper = 0.0
        toggle = self._gripper.get("toggle", "")
        return HandCommand(
            (linear[0], linear[1], linear[2]),
            (angular[0], angular[1], angular[2]),
            gripper,
            bool(self.slow_button) and self.slow_button in pressed,
            turbo,
            any(linear) or any(angular) or gripper != 0.0,
            frozenset(name for name, button in self._actions.items() if button in pressed),
            held and bool(toggle) and toggle in pressed,
        )

    def _gripper_speed(self, sample: HandSample) -> float:
        of = self._gripper
        found = _beyond(sample.axes.get(of.get("axis", ""), 0.0), self.deadzone)
        opens, closes = (bool(of.get(key)) and of[key] in sample.buttons for key in _GRIPPER[1:3])
        return _clipped(found + opens - closes)


_GRIPPER = ("axis", "open", "close", "toggle")
_TEXTS = ("device", "robot", "enable_button", "enable_turbo_button", "slow_button")
_DIRECTIONS = {
    f"{kind}_{which}": names
    for kind in ("axis", "scale", "button")
    for which, names in (("linear", LINEAR), ("angular", ANGULAR))
}
_KEYS = (*_TEXTS, "frame", "speeds", "deadzone", "gripper", "actions", *_DIRECTIONS)


class FieldReader:
    """Reader of the fields of a mapping file, whose errors name the place.

    Args:
        path: The file.
        text: Its text, for the lines of errors.
    """

    def __init__(self, path: Path, text: str = "") -> None:
        self._path, self._text = path, text

    def table(self, value: Any, what: str, known: tuple[str, ...] | None = None) -> dict[str, Any]:
        """Return a YAML mapping after a check of its keys, if the known ones are given.

        Raises:
            InvalidFileError: The value is of another type.
        """
        named = f"'{what}'" if what else "the file"
        if not isinstance(value, dict):
            raise self.error(f"{named} is a mapping of names to values, not {value!r}", what)
        for key in value:
            if known is not None and key not in known:
                place = f"{what}.{key}".lstrip(".")
                problem = f"{named} has no '{key}'; it has {', '.join(known)}"
                raise self.error(problem, place, hint=did_you_mean(str(key), known))
        return value

    def texts(self, value: Any, what: str, known: tuple[str, ...] | None = None) -> dict[str, str]:
        """Return a mapping to names.

        Raises:
            InvalidFileError: The value is of another type.
        """
        table = self.table(value, what, known)
        return {str(key): self.text(each, f"{what}.{key}") for key, each in table.items()}

    def text(self, value: Any, what: str) -> str:
        """Return a name; axes and buttons of ``sensor_msgs/msg/Joy`` have numbers.

        Raises:
            InvalidFileError: The value is of another type.
        """
        if isinstance(value, int) and not isinstance(value, bool):
            return str(value)
        if not isinstance(value, str):
            raise self.error(f"'{what}' is a name in quotes, not {value!r}", what)
        return value

    def number(self, value: Any, what: str, least: float, most: float) -> float:
        """Return a number in a range.

        Raises:
            InvalidFileError: The value is of another type.
        """
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(value) or not least <= value <= most:
            raise self.error(
                f"'{what}' is a number from {least:g} to {most:g}, not {value!r}", what
            )
        return float(value)

    def error(self, problem: str, where: str = "", *, hint: str | None = None) -> InvalidFileError:
        """Return the error for a field, with the line of the file."""
        line = line_of(self._text, where.split("."))
        return InvalidFileError(
            f"{self._path}{line} is no mapping of a teleop device: {problem}", hint=hint
        )


class _Reader(FieldReader):
    """Reader of the mapping of a device."""

    def mapping(self, document: Any) -> HandMapping:
        fields = self.table(document, "", _KEYS)
        texts = {name: self.text(fields.get(name, ""), name) for name in _TEXTS}
        if not texts["device"]:
            raise self.error("'device' is missing: the device for which the mapping is")
        frame = fields.get("frame", "base")
        if frame not in _FRAMES:
            raise self.error(f"'frame' is {' or '.join(_FRAMES)}, not {frame!r}", "frame")
        speeds = fields.get("speeds", list(_SPEEDS))
        if not isinstance(speeds, list) or not speeds:
            raise self.error(f"'speeds' is a list of numbers, not {speeds!r}", "speeds")
        return HandMapping(
            **texts,
            frame=frame,
            speeds=tuple(self.number(each, "speeds", 0.0, 1.0) for each in speeds),
            deadzone=self.number(fields.get("deadzone", _DEADZONE), "deadzone", 0.0, 0.9),
            _linear=self._directions(fields, "linear", LINEAR),
            _angular=self._directions(fields, "angular", ANGULAR),
            _gripper=self.texts(fields.get("gripper", {}), "gripper", _GRIPPER),
            _actions=self.texts(fields.get("actions", {}), "actions", ACTIONS),
        )

    def _directions(
        self, fields: Mapping[str, Any], which: str, names: tuple[str, ...]
    ) -> tuple[_Direction, ...]:
        axes = self.texts(fields.get(f"axis_{which}", {}), f"axis_{which}", names)
        scales = self.table(fields.get(f"scale_{which}", {}), f"scale_{which}", names)
        buttons = self.table(fields.get(f"button_{which}", {}), f"button_{which}", names)
        found = []
        for name in names:
            pair = buttons.get(name, ["", ""])
            if not isinstance(pair, list) or len(pair) != 2:
                raise self.error(
                    f"'button_{which}.{name}' is a list of two buttons, for + and -, not {pair!r}",
                    f"button_{which}.{name}",
                )
            plus, minus = (self.text(each, f"button_{which}.{name}") for each in pair)
            scale = self.number(scales.get(name, 1.0), f"scale_{which}.{name}", -1.0, 1.0)
            found.append(_Direction(axes.get(name, ""), scale, plus, minus))
        return tuple(found)


def mapping_file(name: str | Path, robot: str, folder: Path) -> Path:
    """Return the file of a mapping, by path or by name; a file for the robot comes first.

    Raises:
        NotFoundError: There is no such mapping.
    """
    path = Path(name)
    if path.suffix in (".yaml", ".yml"):
        return path
    own = folder / f"{name}_{robot}.yaml"
    path = own if robot and own.is_file() else folder / f"{name}.yaml"
    if not path.is_file():
        known = sorted(each.stem for each in folder.glob("*.yaml"))
        raise NotFoundError(
            f"There is no mapping '{name}'",
            hint=f"{did_you_mean(str(name), known) or ''} Known: {', '.join(known)}; "
            "or a path that ends with .yaml".strip(),
        )
    return path


def read_mapping(path: Path) -> str:
    """Return the text of a mapping file.

    Raises:
        InvalidFileError: It cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InvalidFileError(f"The mapping {path} cannot be read: {reason}") from error


def check_robot(path: Path, robot: str, driven: str) -> None:
    """Raise an error if a mapping is for another robot than the driven one.

    Raises:
        InvalidFileError: The mapping is for another robot.
    """
    if robot and driven and robot != driven:
        raise InvalidFileError(
            f"{path} is a mapping for the robot '{robot}', and '{driven}' is driven",
            hint="Copy the file and change its 'robot' and its axes, or leave 'robot' empty.",
        )


def line_of(text: str, keys: Sequence[str]) -> str:
    """Return ``:LINE`` of a key in a YAML text; empty if there is none."""
    node = compose(text) if text else None
    line = ""
    for name in keys:
        if not isinstance(node, MappingNode):
            break
        pair = next((pair for pair in node.value if pair[0].value == name), None)
        if pair is None:
            break
        line, node = f":{pair[0].start_mark.line + 1}", pair[1]
    return line


def _beyond(value: float, deadzone: float) -> float:
    """Return the value of an axis outside its dead zone; 0 for a value that is not finite."""
    if not math.isfinite(value) or abs(value) <= deadzone:
        return 0.0
    return math.copysign((min(abs(value), 1.0) - deadzone) / (1.0 - deadzone), value)


def _clipped(value: float) -> float:
    return max(-1.0, min(1.0, value))


def _summed(
    one: tuple[float, float, float], other: tuple[float, float, float]
) -> tuple[float, float, float]:
    x, y, z = (_clipped(a + b) for a, b in zip(one, other, strict=True))
    return x, y, z
