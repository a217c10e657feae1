"""Gamepads and joysticks: the kernel's joystick devices on Linux, pygame elsewhere.

Numbers and signs are those of ROS 2's ``joy``: hats are the last axes, up and left are positive,
and a trigger is 1 at rest and -1 when it is pressed.
"""

from __future__ import annotations

import array
import contextlib
import os
import re
import select
import struct
import sys
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from teleopctl.base.extras import extra
from teleopctl.errors import TeleopctlError, did_you_mean
from teleopctl.teleop.device import DeviceError, HandSample

_FOLDER = Path("/dev/input")
_IS_LINUX = sys.platform.startswith("linux")

# struct js_event and the requests of <linux/joystick.h>.
_EVENT = struct.Struct("IhBB")
_BUTTON, _AXIS = 0x01, 0x02
_GET_AXES, _GET_BUTTONS = 0x80016A11, 0x80016A12
_GET_NAME, _LONGEST_NAME = 0x80006A13, 128
_GET_AXIS_CODES, _MOST_AXES = 0x80406A32, 0x40
_GET_BUTTON_CODES, _MOST_BUTTONS, _FIRST_BUTTON = 0x84006A34, 0x200, 0x100
_FULL = 32767.0
# Polling period of pygame, s: without a window it offers no event to wait for.
_PERIOD_S = 0.004
# Polling period for a joystick that was unplugged, s.
_LOOK_S = 1.0

# Names of the kernel's codes, <linux/input-event-codes.h>, as in Documentation/input/gamepad.rst.
_AXIS_NAMES = {
    0x00: "left_x",
    0x01: "left_y",
    0x02: "left_trigger",
    0x03: "right_x",
    0x04: "right_y",
    0x05: "right_trigger",
    0x10: "dpad_x",
    0x11: "dpad_y",
}
# Pads that have these as triggers have their right stick in the place of the others' triggers.
_GAS, _BRAKE = 0x09, 0x0A
_WITH_PEDALS = {_GAS: "right_trigger", _BRAKE: "left_trigger", 0x02: "right_x", 0x05: "right_y"}
_BUTTON_NAMES = {
    0x130: "a",
    0x131: "b",
    0x133: "y",
    0x134: "x",
    0x136: "left_bumper",
    0x137: "right_bumper",
    0x138: "left_trigger",
    0x139: "right_trigger",
    0x13A: "back",
    0x13B: "start",
    0x13C: "guide",
    0x13D: "left_stick",
    0x13E: "right_stick",
    0x220: "dpad_up",
    0x221: "dpad_down",
    0x222: "dpad_left",
    0x223: "dpad_right",
}
# The kernel's driver of Xbox pads gives these two letters, not the places of the other drivers.
_OF_XBOX = {0x133: "x", 0x134: "y"}
_XBOX = re.compile("x-?box|microsoft", re.IGNORECASE)

# Where the codes are unknown, they are taken to be those of an Xbox pad.
_XBOX_AXES = (0, 1, 2, 3, 4, 5, 0x10, 0x11)
_XBOX_BUTTONS = (*(0x130, 0x131, 0x133, 0x134, 0x136, 0x137), *(0x13A, 0x13B, 0x13C, 0x13D, 0x13E))

_TRIGGERS = ("left_trigger", "right_trigger")
# Axes that are 1 at rest.
_AT_ONE = [[name] for name in _TRIGGERS]
_DPAD = {"dpad_x": ("dpad_left", "dpad_right"), "dpad_y": ("dpad_up", "dpad_down")}


class JoystickInfo(NamedTuple):
    """Description of an attached joystick.

    Attributes:
        number: Number of the joystick, ``device_id`` of ``joy_node``.
        name: Name that it gives itself.
        path: Its device file; empty where there is none.
    """

    number: int
    name: str
    path: str


class Joystick(ABC):
    """An open joystick.

    Attributes:
        name: Name that it gives itself.
        axes: Positions of its axes, -1 to 1, up and left positive.
        buttons: Whether each button is pressed.
    """

    def __init__(self, name: str, axes: int, buttons: int) -> None:
        self.name = name
        self.axes = [0.0] * axes
        self.buttons = [False] * buttons

    axis_codes: Sequence[int] = _XBOX_AXES
    button_codes: Sequence[int] = _XBOX_BUTTONS

    @abstractmethod
    def read(self, timeout_s: float) -> bool:
        """Wait for a change of an axis or a button; return whether there was one.

        Raises:
            DeviceError: The joystick is gone.
        """

    @abstractmethod
    def close(self) -> None:
        """Close the joystick."""

    def axis_names(self) -> list[str]:
        """Return the name of each axis, by its place; empty for one without a known place."""
        codes = list(self.axis_codes)[: len(self.axes)]
        names = dict(_AXIS_NAMES)
        if _GAS in codes and _BRAKE in codes:
            names |= _WITH_PEDALS
        return [names.get(code, "") for code in codes]

    def button_names(self) -> list[str]:
        """Return the name of each button, by its place; empty for one without a known place."""
        is_xbox = not self.name or _XBOX.search(self.name) is not None
        names = {**_BUTTON_NAMES, **(_OF_XBOX if is_xbox else {})}
        return [names.get(code, "") for code in list(self.button_codes)[: len(self.buttons)]]

    def inputs(self) -> frozenset[str]:
        """Return the names of all axes and buttons of the joystick."""
        axes = [name for name in self.axis_names() if name]
        pads = [name for axis, names in _DPAD.items() if axis in axes for name in names]
        return frozenset((*axes, *pads, *(name for name in self.button_names() if name)))

    def sample(self, sequence: int) -> HandSample:
        """Return the state by names: triggers from 0 to 1, the directional pad as buttons."""
        axes = {
            name: value for name, value in zip(self.axis_names(), self.axes, strict=False) if name
        }
        pressed = {
            name
            for name, down in zip(self.button_names(), self.buttons, strict=False)
            if down and name
        }
        for name in _TRIGGERS:
            if name in axes:
                axes[name] = (1.0 - axes[name]) / 2.0
                pressed |= {name} if axes[name] > 0.5 else set()
        for axis, (positive, negative) in _DPAD.items():
            value = axes.pop(axis, 0.0)
            pressed |= {positive} if value > 0.5 else {negative} if value < -0.5 else set()
        return HandSample(axes=axes, buttons=frozenset(pressed), sequence=sequence)


class KernelJoystick(Joystick):
    """Joystick device of Linux, ``/dev/input/js0`` and so on, or what gives the same records.

    Args:
        path: The device file.

    Raises:
        DeviceError: The file cannot be opened.
    """

    def __init__(self, path: str) -> None:
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise DeviceError(
                f"The joystick {path} cannot be opened: {error.strerror}", hint=_permission(error)
            ) from error
        self._path = path
        self._pending: deque[tuple[int, int, int, int]] = deque()
        axes, buttons = (self._ioctl(request, 1)[0] for request in (_GET_AXES, _GET_BUTTONS))
        super().__init__(_name(self._file), axes, buttons)
        if axes or buttons:
            self.axis_codes = self._ioctl(_GET_AXIS_CODES, _MOST_AXES)[:axes]
            codes = array.array("H", self._ioctl(_GET_BUTTON_CODES, 2 * _MOST_BUTTONS))
            self.button_codes = list(codes)[:buttons]

    def _ioctl(self, request: int, size: int) -> bytes:
        """Return the result of an ioctl; zeros for a file that is no joystick."""
        import fcntl

        answer = bytearray(size)
        with contextlib.suppress(OSError):
            fcntl.ioctl(self._file, request, answer)
        return bytes(answer)

    def read(self, timeout_s: float) -> bool:
        """Wait for a change of an axis or a button; return whether there was one.

        Raises:
            DeviceError: The joystick is gone.
        """
        if not self._pending and not self._receive(timeout_s):
            return False
        axes, buttons = self.axes.copy(), self.buttons.copy()
        # Up to a button's change: a press and its release may have come together.
        while self._pending and buttons == self.buttons:
            _, value, kind, number = self._pending.popleft()
            if kind & _AXIS:
                while len(self.axes) <= number:
                    self.axes.append(0.0)
                    self.axes[-1] = 1.0 if self.axis_names()[-1:] in _AT_ONE else 0.0
                self.axes[number] = -max(value / _FULL, -1.0)
            elif kind & _BUTTON:
                missing = number + 1 - len(self.buttons)
                self.buttons += [False] * missing
                buttons += [False] * missing
                self.buttons[number] = bool(value)
        return (axes, buttons) != (self.axes, self.buttons)

    def _receive(self, timeout_s: float) -> bool:
        """Wait for events; return whether there are any."""
        readable, _, _ = select.select([self._file], [], [], timeout_s)
        if not readable:
            return False
        try:
            data = os.read(self._file, 64 * _EVENT.size)
        except BlockingIOError:
            return False
        except OSError as error:
            raise DeviceError(f"The joystick {self._path} is gone: {error.strerror}") from error
        if not data:
            raise DeviceError(f"The joystick {self._path} is gone")
        whole = data[: len(data) // _EVENT.size * _EVENT.size]
        self._pending.extend(_EVENT.iter_unpack(whole))
        return True

    def close(self) -> None:
        """Close the joystick."""
        os.close(self._file)


class PygameJoystick(Joystick):
    """Joystick that pygame reads.

    Args:
        pygame: The module.
        number: Number of the joystick.
    """

    # Any: objects of a module that may not be installed.
    def __init__(self, pygame: ModuleType, number: int) -> None:
        self._pygame: Any = pygame
        self._joystick = stick = self._pygame.joystick.Joystick(number)
        stick.init()
        super().__init__(
            str(stick.get_name()),
            stick.get_numaxes() + 2 * stick.get_numhats(),
            stick.get_numbuttons(),
        )
        self._is_gone = False

    def read(self, timeout_s: float) -> bool:
        """Wait for a change of an axis or a button; return whether there was one.

        Raises:
            DeviceError: The joystick is gone.
        """
        end_s = time.monotonic() + timeout_s
        while True:
            for event in self._pygame.event.get():
                removed = event.type == self._pygame.JOYDEVICEREMOVED
                if removed and event.instance_id == self._joystick.get_instance_id():
                    raise DeviceError(f"The joystick '{self.name}' is gone")
            axes, buttons = self._state()
            if (axes, buttons) != (self.axes, self.buttons):
                self.axes, self.buttons = axes, buttons
                return True
            if time.monotonic() >= end_s:
                return False
            time.sleep(_PERIOD_S)

    def _state(self) -> tuple[list[float], list[bool]]:
        stick = self._joystick
        axes = [-max(stick.get_axis(number), -1.0) for number in range(stick.get_numaxes())]
        for number in range(stick.get_numhats()):
            right, up = stick.get_hat(number)
            axes += [-float(right), float(up)]
        return axes, [bool(stick.get_button(number)) for number in range(stick.get_numbuttons())]

    def close(self) -> None:
        """Close the joystick."""
        self._joystick.quit()


def find_joysticks() -> list[JoystickInfo]:
    """Return the joysticks that are attached, sorted by number.

    Raises:
        MissingExtraError: This system needs pygame, which is not installed.
    """
    if not _IS_LINUX:
        sticks = _pygame().joystick
        count = range(sticks.get_count())
        return [JoystickInfo(each, str(sticks.Joystick(each).get_name()), "") for each in count]
    found = []
    for path in _FOLDER.glob("js*"):
        if path.name[2:].isdigit():
            name = ""
            with contextlib.suppress(OSError):
                file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
                try:
                    name = _name(file)
                finally:
                    os.close(file)
            found.append(JoystickInfo(int(path.name[2:]), name, str(path)))
    return sorted(found)


def choose_joystick(number: int | None = None, name: str = "") -> JoystickInfo:
    """Return the joystick of a number or a name, or the only one.

    Args:
        number: Its number; None for the only one.
        name: Its name, which goes before the number; empty for any.

    Raises:
        DeviceError: There is none, it is another one, or there are several.
        MissingExtraError: This system needs pygame, which is not installed.
    """
    found = find_joysticks()
    names = [each.name for each in found]
    listed = _listed(found)
    if not found:
        hint = "Switch it on, or plug it in. Without one, `teleopctl drive` has keys and pads."
        if any(_FOLDER.glob("by-*/*-event-joystick")):
            hint = "One is plugged in, but has no joystick device: sudo modprobe joydev"
        raise DeviceError("No gamepad is attached", hint=hint)
    if name:
        chosen = next((each for each in found if each.name == name), None)
        if chosen is None:
            raise DeviceError(
                f"No gamepad has the name '{name}'; there is {listed}",
                hint=did_you_mean(name, names),
            )
        return chosen
    if number is None:
        if len(found) > 1:
            raise DeviceError(
                several(found),
                hint="Choose one with the parameter device_id or device_name.",
            )
        return found[0]
    chosen = next((each for each in found if each.number == number), None)
    if chosen is None:
        raise DeviceError(f"There is no gamepad {number}; there is {listed}")
    return chosen


def several(found: Sequence[JoystickInfo]) -> str:
    """Return the error text for several joysticks where one is needed."""
    return f"{len(found)} gamepads are attached ({_listed(found)})"


def _listed(found: Sequence[JoystickInfo]) -> str:
    return ", ".join(f"{each.number}: {each.name or each.path}" for each in found)


def open_joystick(number: int | None = None, name: str = "", path: str = "") -> Joystick:
    """Open the joystick of a path, a name or a number, or the only one; see `choose_joystick`.

    Raises:
        DeviceError: There is none, it is another one, there are several, or it cannot be opened.
        MissingExtraError: This system needs pygame, which is not installed.
    """
    if path:
        return KernelJoystick(path)
    chosen = choose_joystick(number, name)
    return KernelJoystick(chosen.path) if chosen.path else PygameJoystick(_pygame(), chosen.number)


def keep_open(
    open_one: Callable[[], Joystick],
    use: Callable[[Joystick], object],
    report: Callable[[TeleopctlError], object],
    ending: threading.Event,
) -> None:
    """Open a joystick and read it until the end; open it again after it was unplugged.

    Args:
        open_one: Function that opens it.
        use: Function that reads it until it is gone or the end has come.
        report: Called with what is wrong, once for each problem.
        ending: Set at the end.
    """
    said = ""
    while not ending.is_set():
        joystick: Joystick | None = None
        try:
            joystick = open_one()
            said = ""
            use(joystick)
        except TeleopctlError as error:
            if error.message != said:
                said = error.message
                report(error)
            ending.wait(_LOOK_S)
        finally:
            if joystick is not None:
                joystick.close()


def _name(file: int) -> str:
    import fcntl

    answer = bytearray(_LONGEST_NAME)
    try:
        fcntl.ioctl(file, _GET_NAME | _LONGEST_NAME << 16, answer)
    except OSError:
        return ""
    return answer.partition(b"\0")[0].decode(errors="replace")


def _permission(error: OSError) -> str | None:
    if not isinstance(error, PermissionError):
        return None
    return "Join the group that owns it: sudo usermod -aG input $USER, then log in again."


# Any: a module that may not be installed.
def _pygame() -> Any:
    """Return pygame, which reads joysticks without a window."""
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with extra("gamepad", "pygame"):
        import pygame
    if not pygame.joystick.get_init():
        pygame.display.init()
        pygame.joystick.init()
    pygame.event.pump()
    return pygame
