"""``rclpy.signals``. Signals that end contexts, and guard conditions for the end."""

from teleopctl.node import (
    Context,
    GuardHandle,
    SignalHandlerOptions,
    get_current_signal_handlers_options,
    install_for_all_contexts as install_signal_handlers,
    uninstall_for_all_contexts as uninstall_signal_handlers,
)

__all__ = [
    "SignalHandlerGuardCondition",
    "SignalHandlerOptions",
    "get_current_signal_handlers_options",
    "install_signal_handlers",
    "uninstall_signal_handlers",
]


class SignalHandlerGuardCondition(GuardHandle):
    """A guard condition that is triggered when a context ends, by a signal or otherwise."""

    def __init__(self, context: Context | None = None) -> None:
        self._context = context or Context.default()
        super().__init__(self._context.handle)
        self._context.on_shutdown(self.entity.trigger)

    @property
    def handle(self) -> GuardHandle:
        """Handle, to be added to a wait set."""
        return self

    def destroy(self) -> None:
        """Unregister the guard condition from the context."""
        self._context.forget_on_shutdown(self.entity.trigger)
