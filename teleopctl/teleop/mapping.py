"""Mappings: which axis and which button of a device does what, in a YAML file.

A file per device and robot. Its names follow ``teleop_twist_joy``::

    device: gamepad
    robot: ""                      # name of a robot, to which the file then applies alone
    axis_linear: {x: left_y, y: left_x, z: right_y}
    scale_linear: {x: 1.0, y: 1.0, z: 1.0}
    button_linear: {z: [dpad_up, dpad_down]}     # the one for +, the one for -
    axis_angular: {yaw: right_x}
    gripper: {axis: "", open: a, close: b, toggle: x}
    actions: {stop: back, slower: left_bumper, faster: right_bumper}
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from teleopctl.base.ros_yaml import faults_of, safe_load
from teleopctl.errors import InvalidFileError, NotFoundError, did_you_mean
from teleopctl.teleop.device import HandSample

FOLDER = Path(__file__).with_name("mappings")
LINEAR, ANGULAR = ("x", "y", "z"), ("roll", "pitch", "yaw")
ACTIONS = ("stop", "slower", "faster", "base", "tip", "take", "release")
"""Actions of buttons: they begin with the press; ``base`` and ``tip`` choose the twist's axes."""
_FRAMES = ("base", "tip")
_SPEEDS, _SLOW = (0.25, 0.5, 1.0), 0.25
_DEADZONE = 0.1

# Any, here: values of a YAML document.


@dataclass(frozen=True, slots=True)
class HandCommand:
    """What a hand asks for, as parts of the robot's speeds, before the speed step.

    Attributes:
        linear: Direction of the tool along x, y, z, each -1 to 1.
        angular: Rotation about x, y, z, each -1 to 1.
        gripper: Speed of the gripper, 1 opens and -1 closes.
        is_slow: Whether the slow button is held.
        is_held: Whether the hand holds something that moves the robot.
        actions: Actions whose buttons are pressed now.
        toggles_gripper: Whether the button that opens or closes the gripper is pressed.
    """

    linear: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gripper: float = 0.0
    is_slow: bool = False
    is_held: bool = False
    actions: frozenset[str] = frozenset()
    toggles_gripper: bool = False

    def __add__(self, other: HandCommand) -> HandCommand:
        """Return both hands together, each direction at most 1."""
        return HandCommand(
            _summed(self.linear, other.linear),
            _summed(self.angular, other.angular),
            _clipped(self.gripper + other.gripper),
            self.is_slow or other.is_slow,
            self.is_held or other.is_held,
            self.actions | other.actions,
            self.toggles_gripper or other.toggles_gripper,
        )


@dataclass(frozen=True, slots=True)
class _Direction:
    """What moves along one direction: an axis with its scale, and a pair of buttons."""

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
    """What the axes and buttons of a device do, for a robot.

    Attributes:
        device: Device for which the mapping is.
        robot: Name of the robot for which it is; empty for any.
        frame: ``base`` for the axes of the root link, ``tip`` for those of the gripper.
        enable_button: Button without which nothing moves; empty for none.
        slow_button: Button that makes the motion a quarter as fast; empty for none.
        speeds: Speed steps, as parts of the robot's speeds.
        deadzone: Part of an axis around its middle that does nothing.
    """

    device: str
    robot: str = ""
    frame: str = "base"
    enable_button: str = ""
    slow_button: str = ""
    speeds: tuple[float, ...] = _SPEEDS
    deadzone: float = _DEADZONE
    _linear: tuple[_Direction, ...] = ()
    _angular: tuple[_Direction, ...] = ()
    _gripper: Mapping[str, str] = field(default_factory=dict)
    _actions: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def load(cls, name: str | Path, robot: str = "") -> HandMapping:
        """Read a mapping by its name or path; of a name, that for a robot if there is one.

        Args:
            name: Name of a mapping that comes with teleopctl, or a path of a YAML file.
            robot: Name of the robot that is driven.

        Raises:
            NotFoundError: There is no such mapping.
            InvalidFileError: The file cannot be read, is no mapping, or is for another robot.
        """
        path = Path(name)
        if path.suffix not in (".yaml", ".yml"):
            own = FOLDER / f"{name}_{robot}.yaml"
            path = own if robot and own.is_file() else FOLDER / f"{name}.yaml"
            if not path.is_file():
                known = sorted(each.stem for each in FOLDER.glob("*.yaml"))
                raise NotFoundError(
                    f"There is no mapping '{name}'",
                    hint=f"{did_you_mean(str(name), known) or ''} Known: {', '.join(known)}; "
                    "or a path that ends with .yaml".strip(),
                )
        with faults_of(path):
            document = safe_load(path.read_text(encoding="utf-8"))
        mapping = cls.parse(document, path)
        if mapping.robot and robot and mapping.robot != robot:
            raise InvalidFileError(
                f"{path} is a mapping for the robot '{mapping.robot}', and '{robot}' is driven",
                hint="Copy the file and change its 'robot' and its axes, or leave 'robot' empty.",
            )
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

    def command(self, sample: HandSample) -> HandCommand:
        """Return what a sample asks for."""
        pressed = sample.buttons
        held = not self.enable_button or self.enable_button in pressed
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
_TEXTS = ("device", "robot", "enable_button", "slow_button")
_DIRECTIONS = {
    f"{kind}_{which}": names
    for kind in ("axis", "scale", "button")
    for which, names in (("linear", LINEAR), ("angular", ANGULAR))
}
_KEYS = (*_TEXTS, "frame", "speeds", "deadzone", "gripper", "actions", *_DIRECTIONS)


class _Reader:
    """Reader of a mapping file, whose errors name the place."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def mapping(self, document: Any) -> HandMapping:
        fields = self._table(document, "the file", _KEYS)
        texts = {name: self._text(fields.get(name, ""), name) for name in _TEXTS}
        if not texts["device"]:
            raise self._error("'device' is missing: the device for which the mapping is")
        frame = fields.get("frame", "base")
        if frame not in _FRAMES:
            raise self._error(f"'frame' is {' or '.join(_FRAMES)}, not {frame!r}")
        speeds = fields.get("speeds", list(_SPEEDS))
        if not isinstance(speeds, list) or not speeds:
            raise self._error(f"'speeds' is a list of numbers, not {speeds!r}")
        return HandMapping(
            **texts,
            frame=frame,
            speeds=tuple(self._number(each, "speeds", 0.0, 1.0) for each in speeds),
            deadzone=self._number(fields.get("deadzone", _DEADZONE), "deadzone", 0.0, 0.9),
            _linear=self._directions(fields, "linear", LINEAR),
            _angular=self._directions(fields, "angular", ANGULAR),
            _gripper=self._texts(fields.get("gripper", {}), "gripper", _GRIPPER),
            _actions=self._texts(fields.get("actions", {}), "actions", ACTIONS),
        )

    def _directions(
        self, fields: Mapping[str, Any], which: str, names: tuple[str, ...]
    ) -> tuple[_Direction, ...]:
        axes = self._texts(fields.get(f"axis_{which}", {}), f"axis_{which}", names)
        scales = self._table(fields.get(f"scale_{which}", {}), f"scale_{which}", names)
        buttons = self._table(fields.get(f"button_{which}", {}), f"button_{which}", names)
        found = []
        for name in names:
            pair = buttons.get(name, ["", ""])
            if not isinstance(pair, list) or len(pair) != 2:
                raise self._error(
                    f"'button_{which}.{name}' is a list of two buttons, for + and -, not {pair!r}"
                )
            plus, minus = (self._text(each, f"button_{which}.{name}") for each in pair)
            scale = self._number(scales.get(name, 1.0), f"scale_{which}.{name}", -1.0, 1.0)
            found.append(_Direction(axes.get(name, ""), scale, plus, minus))
        return tuple(found)

    def _table(self, value: Any, what: str, known: tuple[str, ...]) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self._error(f"'{what}' is a mapping of names to values, not {value!r}")
        for key in value:
            if key not in known:
                raise self._error(f"'{what}' has no '{key}'; it has {', '.join(known)}")
        return value

    def _texts(self, value: Any, what: str, known: tuple[str, ...]) -> dict[str, str]:
        table = self._table(value, what, known)
        return {key: self._text(each, f"{what}.{key}") for key, each in table.items()}

    def _text(self, value: Any, what: str) -> str:
        if not isinstance(value, str):
            raise self._error(f"'{what}' is a name in quotes, not {value!r}")
        return value

    def _number(self, value: Any, what: str, least: float, most: float) -> float:
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(value) or not least <= value <= most:
            raise self._error(f"'{what}' is a number from {least:g} to {most:g}, not {value!r}")
        return float(value)

    def _error(self, problem: str) -> InvalidFileError:
        return InvalidFileError(f"{self._path} is no mapping of a teleop device: {problem}")


def _beyond(value: float, deadzone: float) -> float:
    """Return an axis without its dead middle; 0 for a value that is not finite."""
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
