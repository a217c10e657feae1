"""``launch_ros.events.lifecycle.state_transition``."""

from __future__ import annotations

from typing import Any

from launch.event import Event
from lifecycle_msgs.msg import TransitionEvent


class StateTransition(Event):
    """Emitted when a lifecycle node has changed its state.

    Args:
        action: The node.
        msg: Received ``TransitionEvent`` message.
    """

    name = "launch_ros.events.lifecycle.StateTransition"

    # Any: the action of a lifecycle node, which imports this module.
    def __init__(self, *, action: Any, msg: TransitionEvent) -> None:
        super().__init__()
        self._action = action
        self._msg = msg

    @property
    def action(self) -> Any:
        """Action of the node."""
        return self._action

    @property
    def msg(self) -> TransitionEvent:
        """Received ``TransitionEvent`` message."""
        return self._msg

    @property
    def timestamp(self) -> int:
        """Time of the transition in nanoseconds."""
        return int(self._msg.timestamp)

    @property
    def transition(self) -> str:
        """The transition's label."""
        return str(self._msg.transition.label)

    @property
    def start_state(self) -> str:
        """Label of the start state."""
        return str(self._msg.start_state.label)

    @property
    def goal_state(self) -> str:
        """Label of the goal state."""
        return str(self._msg.goal_state.label)
