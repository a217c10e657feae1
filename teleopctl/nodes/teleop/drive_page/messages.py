"""Messages of the drive page's websocket: JSON texts, documented in docs/drive.md.

The browser sends the state of its inputs and presses of buttons; it receives the robot's state.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from teleopctl.errors import UsageError
from teleopctl.teleop import EPISODE, EPISODE_STEPS, HandSample

LONGEST_MESSAGE = 16_384
"""Characters of the longest message that is read."""
_MOST = 64
PRESSES = (
    *("stop", "release_stop", "slower", "faster", "base", "tip", "take", "release"),
    *("engage", "disengage"),
    *(f"{EPISODE}{step}" for step in EPISODE_STEPS),
)
"""Actions of the page's buttons."""

# The standard layout of the browsers' gamepads. Source: https://w3c.github.io/gamepad/#remapping
STANDARD_AXES = ("left_x", "left_y", "right_x", "right_y")
STANDARD_BUTTONS = (
    *("a", "b", "x", "y", "left_bumper", "right_bumper", "left_trigger", "right_trigger"),
    *("back", "start", "left_stick", "right_stick"),
    *("dpad_up", "dpad_down", "dpad_left", "dpad_right", "guide"),
)

# Any, here: values of a JSON document.


@dataclass(frozen=True, slots=True)
class Hands:
    """State of all inputs of a browser: keys, touch pads and gamepads.

    Attributes:
        sequence: Number of the message, which grows.
        samples: Sample of each device of the page, by name: ``keys``, ``pads``, ``gamepad``.
        problem: Why the gamepad is not used, in words; empty if it is, or if there is none.
        drags: Whether a mouse button or a finger is held in the 3D view.
        document: The message without its sequence; the same object while nothing changes.
    """

    sequence: int
    samples: Mapping[str, HandSample] = field(default_factory=dict)
    problem: str = ""
    drags: bool = False
    document: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class GripperWish:
    """Opening of the gripper, 0 (closed) to 1 (open), set by the page's slider."""

    opening: float


@dataclass(frozen=True, slots=True)
class Press:
    """Press of a button of the page, one of `PRESSES`."""

    action: str


def parse_message(text: str | bytes, last: Hands | None = None) -> Hands | GripperWish | Press:
    """Return the parsed message of a browser.

    Args:
        text: The message.
        last: Newest message of the inputs: one with the same inputs has the same samples.

    Raises:
        UsageError: The text is no message of the page.
    """
    if isinstance(text, bytes) or len(text) > LONGEST_MESSAGE:
        raise UsageError("a message is a JSON text of 16 kB at most")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        raise UsageError("a message is no JSON") from None
    kind = message.get("type") if isinstance(message, dict) else None
    if kind == "hands":
        sequence = int(_number(message.pop("sequence", None), "sequence", 0.0, 2.0**53))
        if last is not None and message == last.document:
            return replace(last, sequence=sequence)
        samples, problem, drags = _inputs(message)
        return Hands(sequence, samples, problem, drags, message)
    if kind == "gripper":
        return GripperWish(_number(message.get("opening"), "opening", 0.0, 1.0))
    if kind == "press":
        if message.get("action") not in PRESSES:
            raise UsageError(f"'action' is one of {', '.join(PRESSES)}")
        return Press(message["action"])
    raise UsageError("'type' is hands, gripper or press")


def _inputs(message: Mapping[str, Any]) -> tuple[Mapping[str, HandSample], str, bool]:
    """Return samples, the gamepad's problem, and whether something is dragged."""
    keys = _names(message.get("keys", []), "keys")
    pads = message.get("pads", {})
    if not isinstance(pads, dict) or len(pads) > _MOST:
        raise UsageError("'pads' is an object of axes by name")
    axes = {str(name): _number(value, "pads", -1.0, 1.0) for name, value in pads.items()}
    samples = {
        "keys": HandSample(buttons=keys),
        "pads": HandSample(axes=axes, buttons=keys & {"ShiftLeft"}),
    }
    drags = message.get("drags", False)
    if not isinstance(drags, bool):
        raise UsageError("'drags' is true or false")
    gamepads = _list(message.get("gamepads", []), "gamepads")
    problem = ""
    if len(gamepads) > 1:
        names = ", ".join(str(_field(pad, "id"))[:60] for pad in gamepads)
        problem = f"{len(gamepads)} gamepads are on ({names}): switch all but one off"
    elif gamepads and _field(gamepads[0], "mapping") != "standard":
        problem = (
            f"The browser does not know the layout of '{str(_field(gamepads[0], 'id'))[:60]}': "
            "switch it to its standard (Xbox) mode, or use keys or pads"
        )
    elif gamepads:
        samples["gamepad"] = _gamepad(gamepads[0])
    return samples, problem, drags


def _gamepad(pad: Mapping[str, Any]) -> HandSample:
    values = _numbers(_field(pad, "axes"), "axes", -1.0)
    pressures = _numbers(_field(pad, "buttons"), "buttons", 0.0)
    # As in ROS: up and left are positive.
    axes = {name: -value for name, value in zip(STANDARD_AXES, values, strict=False)}
    buttons = dict(zip(STANDARD_BUTTONS, pressures, strict=False))
    axes |= {name: buttons.get(name, 0.0) for name in ("left_trigger", "right_trigger")}
    pressed = frozenset(name for name, pressure in buttons.items() if pressure > 0.5)
    return HandSample(axes=axes, buttons=pressed)


def _field(pad: object, name: str) -> Any:
    if not isinstance(pad, dict) or name not in pad:
        raise UsageError(f"a gamepad has id, mapping, axes and buttons; '{name}' is missing")
    return pad[name]


def _names(value: object, what: str) -> frozenset[str]:
    names = _list(value, what)
    if not all(isinstance(each, str) for each in names):
        raise UsageError(f"'{what}' is a list of names")
    return frozenset(names)


def _numbers(value: object, what: str, least: float) -> Sequence[float]:
    return [_number(each, what, least, 1.0) for each in _list(value, what)]


def _list(value: object, what: str) -> list[Any]:
    if not isinstance(value, list) or len(value) > _MOST:
        raise UsageError(f"'{what}' is a list of at most {_MOST}")
    return value


def _number(value: object, what: str, least: float, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise UsageError(f"'{what}' is a number")
    # Sticks of some gamepads reach a little further.
    if not least - 0.1 <= value <= most + 0.1:
        raise UsageError(f"'{what}' is from {least:g} to {most:g}")
    return max(least, min(most, float(value)))
