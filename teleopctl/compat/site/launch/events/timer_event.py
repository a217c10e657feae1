"""``launch.events.timer_event``."""

from ..action import Action
from ..event import Event


class TimerEvent(Event):
    """Emitted when a timer fires.

    Args:
        timer_action: The timer.
    """

    name = "launch.events.TimerEvent"

    def __init__(self, *, timer_action: Action) -> None:
        self.timer_action = timer_action
