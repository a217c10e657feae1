"""Every number of a session, recorded and replayed, for a picture of what differs."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from teleopctl.bag.look.curves import Curve
from teleopctl.bag.verify.comparison import Difference, differences
from teleopctl.interfaces import to_seconds

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState


class Traces:
    """Keeps what is compared: 32 bytes a number and state."""

    def __init__(self) -> None:
        self._times: dict[tuple[str, str], array[float]] = {}
        self._recorded: dict[tuple[str, str], array[float]] = {}
        self._replayed: dict[tuple[str, str], array[float]] = {}

    def note(self, time_ns: int, recorded: JointState, replayed: JointState) -> None:
        """Keep the state of a simulated time, in nanoseconds, as it was and as it is now."""
        for pair in differences(time_ns, recorded, replayed):
            key = (pair.joint, pair.field)
            for kept, value in (
                (self._times, to_seconds(time_ns)),
                (self._recorded, pair.recorded),
                (self._replayed, pair.replayed),
            ):
                kept.setdefault(key, array("d")).append(value)

    def curves(self, difference: Difference) -> list[Curve]:
        """Return the two curves of a joint's field that differs, over simulated seconds."""
        key = (difference.joint, difference.field)
        name = f"{difference.joint} {difference.field}"
        times = self._times[key].tolist()
        return [
            Curve(f"{name}, recorded", times, self._recorded[key].tolist()),
            Curve(f"{name}, now", times, self._replayed[key].tolist()),
        ]
