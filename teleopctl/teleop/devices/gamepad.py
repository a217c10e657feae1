"""Teleop device ``gamepad``: a gamepad of this machine, without a browser and without a node."""

from __future__ import annotations

import threading
from collections.abc import Callable

from teleopctl.errors import TeleopctlError
from teleopctl.node import Node
from teleopctl.teleop.device import DeviceError, HandSample, TeleopDevice
from teleopctl.teleop.joystick import (
    Joystick,
    choose_joystick,
    find_joysticks,
    keep_open,
    open_joystick,
    several,
)

# Time between two samples while something is held, and while nothing is, s.
_HELD_S, _IDLE_S = 0.02, 0.2
# Position of an axis from which on it may be held.
_STILL = 0.05


class Gamepad(TeleopDevice):
    """A gamepad; axes and buttons have the names of the browsers' standard layout.

    Its node's parameters ``device_id``, ``device_name`` and ``dev`` choose it, as for ``joy_node``;
    without them it is the only one.
    """

    mapping = "gamepad"

    def __init__(self, node: Node, emit: Callable[[HandSample], object]) -> None:
        super().__init__(node, emit)
        number = int(node.declare_parameter("device_id", -1).value)
        self._number = None if number < 0 else number
        self._name = str(node.declare_parameter("device_name", "").value)
        self._path = str(node.declare_parameter("dev", "").value)
        self._first: Joystick | None = None
        self._sequence = 0
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    @classmethod
    def check(cls) -> None:
        """Check that one gamepad is attached.

        Raises:
            DeviceError: There is none, or there are several.
            MissingExtraError: This system needs pygame, which is not installed.
        """
        found = find_joysticks()
        if len(found) > 1:
            raise DeviceError(
                several(found),
                hint="Start `teleopctl drive` without it, and choose one in another terminal: "
                "teleopctl run teleop_device teleop_device gamepad "
                f"--ros-args -p device_id:={found[0].number}",
            )
        choose_joystick()

    def start(self) -> None:
        """Open the gamepad.

        Raises:
            DeviceError: There is no gamepad, there are several, or it cannot be used.
            MissingExtraError: This system needs pygame, which is not installed.
        """
        self._first = self._open()
        self._thread = threading.Thread(target=self._run, name="gamepad", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Close the gamepad."""
        self._ending.set()
        if self._thread is not None:
            self._thread.join()

    def inputs(self) -> frozenset[str]:
        """Return the names of the gamepad's axes and buttons; empty before they are known."""
        return frozenset() if self._first is None else self._first.inputs()

    def _open(self) -> Joystick:
        return open_joystick(self._number, self._name, self._path)

    def _run(self) -> None:
        first = self._first

        def open_one() -> Joystick:
            nonlocal first
            one, first = first, None
            return self._open() if one is None else one

        keep_open(open_one, self._emit_all, self._report, self._ending)

    def _emit_all(self, joystick: Joystick) -> None:
        wait_s = _HELD_S
        sample = joystick.sample(self._sequence)
        try:
            while not self._ending.is_set():
                is_new = joystick.read(wait_s)
                if is_new:
                    self._sequence += 1
                    sample = joystick.sample(self._sequence)
                held = bool(sample.buttons) or any(
                    abs(value) > _STILL for value in sample.axes.values()
                )
                wait_s = _HELD_S if held else _IDLE_S
                if is_new or held:
                    self.emit(sample)
        except DeviceError:
            self.emit(HandSample(sequence=self._sequence + 1))
            raise

    def _report(self, error: TeleopctlError) -> None:
        hint = f" ({error.hint})" if error.hint else ""
        self.node.get_logger().warning(f"{error.message}{hint}; waiting for it")
