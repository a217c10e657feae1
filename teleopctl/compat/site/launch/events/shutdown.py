"""``launch.events.shutdown``."""

from teleopctl.launch import Launch

from ..event import Event


class Shutdown(Event):
    """Emitted when the launch shuts down.

    Args:
        reason: Why.
        due_to_sigint: Whether SIGINT was received (Ctrl-C).
    """

    name = "launch.events.Shutdown"

    def __init__(self, *, reason: str = "reason not given", due_to_sigint: bool = False) -> None:
        self.reason = reason
        self.due_to_sigint = due_to_sigint

    def happen(self, launch: Launch) -> None:
        """Shut the launch down."""
        launch.shut_down(self.reason)
