"""A gamepad without hardware: a named pipe with the records of the kernel's joystick device."""

import os
import struct
from pathlib import Path

EVENT = struct.Struct("IhBB")
AXES, BUTTONS, TRIGGERS = 8, 11, (2, 5)


class EmulatedGamepad:
    """An Xbox pad: axes 0 to 7, of which 2 and 5 are triggers; buttons 0 to 10."""

    def __init__(self, path: Path) -> None:
        os.mkfifo(path)
        self.path = path
        self._file = os.open(path, os.O_RDWR)
        for number in range(AXES):
            self.send(-32767 if number in TRIGGERS else 0, 0x82, number)
        for number in range(BUTTONS):
            self.send(0, 0x81, number)

    def send(self, value: int, kind: int, number: int) -> None:
        os.write(self._file, EVENT.pack(0, value, kind, number))

    def axis(self, number: int, value: float) -> None:
        """Move an axis, as the kernel counts: down and right are positive."""
        self.send(round(32767 * value), 0x02, number)

    def button(self, number: int, *, is_down: bool) -> None:
        self.send(int(is_down), 0x01, number)

    def unplug(self) -> None:
        os.close(self._file)
