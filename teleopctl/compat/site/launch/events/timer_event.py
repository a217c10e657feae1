"""``launch.events.timer_event``."""

from ..action import Action
from ..event import Event


class TimerEvent(Event):
    """The time of a timer has come.

    Args:
        timer_action: The timer.
    """

    name = "launch.events.TimerEvent"

    def __init__(self, *, timer_action: Action) -> None:
        self.timer_action = timer_action
