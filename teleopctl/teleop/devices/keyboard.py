"""Teleop device ``keyboard``: the keys of the terminal."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable

from teleopctl.base.keyboard import Key, Keyboard, require_keys
from teleopctl.node import Node
from teleopctl.teleop.device import HandSample, TeleopDevice
from teleopctl.teleop.held_keys import HeldKeys

_PERIOD_S = 0.02
# The key that ends the program.
_QUIT = "q"


class TerminalKeys(TeleopDevice):
    """Keys of the terminal; ``q`` ends the program."""

    mapping = "keyboard"
    reads_terminal = True
    help = """\
Keys: arrows and page up/down move, u o i k j l turn, w e choose whose axes, g the gripper.
A base: arrows drive and turn, J L move sideways.
[ ] change the speed, space stops, r releases the stop, q ends."""

    def __init__(self, node: Node, emit: Callable[[HandSample], object]) -> None:
        super().__init__(node, emit)
        self._keys = HeldKeys()
        self._sequence = 0
        self._ending = threading.Event()
        self._keyboard = Keyboard(key=self._on_key)
        self._thread = threading.Thread(target=self._run, name="keys", daemon=True)

    def start(self) -> None:
        """Begin to read keys.

        Raises:
            UsageError: Standard input is no terminal.
        """
        require_keys("The device 'keyboard'", "/servo_node/delta_twist_cmds")
        self._keyboard.__enter__()
        self._thread.start()

    def stop(self) -> None:
        """Restore the terminal."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join()
        self._keyboard.__exit__()

    def _on_key(self, key: Key) -> None:
        if key.name == _QUIT:
            os.kill(os.getpid(), signal.SIGINT)
        else:
            self._keys.on_key(key, time.monotonic())

    def _run(self) -> None:
        held: frozenset[str] = frozenset()
        while not self._ending.wait(_PERIOD_S):
            before, held = held, self._keys.held(time.monotonic())
            if held or before:
                self._sequence += 1
                self.emit(HandSample(buttons=held, sequence=self._sequence))
