"""``launch_ros.events.lifecycle.state_transition``."""

from __future__ import annotations

from typing import Any

from launch.event import Event
from lifecycle_msgs.msg import TransitionEvent


class StateTransition(Event):
    """A lifecycle node has gone from one state to another.

    Args:
        action: The node.
        msg: What it said of that.
    """

    name = "launch_ros.events.lifecycle.StateTransition"

    # Any: a lifecycle node, which knows these events.
    def __init__(self, *, action: Any, msg: TransitionEvent) -> None:
        super().__init__()
        self._action = action
        self._msg = msg

    @property
    def action(self) -> Any:
        """The node."""
        return self._action

    @property
    def msg(self) -> TransitionEvent:
        """What the node said."""
        return self._msg

    @property
    def timestamp(self) -> int:
        """When, in nanoseconds."""
        return int(self._msg.timestamp)

    @property
    def transition(self) -> str:
        """The transition's label."""
        return str(self._msg.transition.label)

    @property
    def start_state(self) -> str:
        """The label of the state that it has left."""
        return str(self._msg.start_state.label)

    @property
    def goal_state(self) -> str:
        """The label of the state that it is in."""
        return str(self._msg.goal_state.label)
