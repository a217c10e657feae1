"""Signal handlers that end the contexts of the process on SIGINT and SIGTERM.

Ctrl-C still raises KeyboardInterrupt in the main thread; the end of the context also ends waits of
other threads.
"""

from __future__ import annotations

import enum
import threading
from _weakrefset import WeakSet  # as `threading` does: `weakref` takes longer to import
from types import FrameType

from teleopctl.base.interrupts import is_swallowed, resend_signal, wake_on_signals
from teleopctl.base.typed import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import signal
else:
    import _signal as signal  # see `interrupts`


class Endable(Protocol):
    """Interface of contexts as the signal handlers use it."""

    def ok(self) -> bool:
        """Return whether the context is initialized and not shut down."""

    def end_by_signal(self) -> None:
        """End the context because of a signal."""


class SignalHandlerOptions(enum.IntEnum):
    """Signals that end a context, as in ``rclpy.signals``."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


_SIGNALS = {
    SignalHandlerOptions.NO: (),
    SignalHandlerOptions.SIGINT: (signal.SIGINT,),
    SignalHandlerOptions.SIGTERM: (signal.SIGTERM,),
    SignalHandlerOptions.ALL: (signal.SIGINT, signal.SIGTERM),
}

# Contexts that were initialized, for handlers that a program installs itself.
_initialized: WeakSet[Endable] = WeakSet()
_contexts: dict[int, set[Endable]] = {signal.SIGINT: set(), signal.SIGTERM: set()}
_previous: dict[int, signal._HANDLER] = {}


def install_signal_handlers(context: Endable, options: SignalHandlerOptions) -> None:
    """Install signal handlers that end a context; has no effect outside the main thread."""
    _initialized.add(context)
    if threading.current_thread() is not threading.main_thread():
        return
    if _SIGNALS[options]:
        wake_on_signals()
    for number in _SIGNALS[options]:
        if signal.getsignal(number) is not _end_contexts:
            _previous[number] = signal.signal(number, _end_contexts)
        _contexts[number].add(context)


def install_for_all_contexts(
    options: SignalHandlerOptions = SignalHandlerOptions.ALL,
) -> None:
    """Install signal handlers that end all contexts of the process that are initialized."""
    for context in _initialized:
        if context.ok():
            install_signal_handlers(context, options)


def uninstall_for_all_contexts() -> None:
    """Stop ending contexts on signals, and restore the handlers from before."""
    for context in _initialized:
        uninstall_signal_handlers(context)


def uninstall_signal_handlers(context: Endable) -> None:
    """Stop ending a context on signals; restores handlers after the last context."""
    for number, contexts in _contexts.items():
        contexts.discard(context)
        if (
            not contexts
            and threading.current_thread() is threading.main_thread()
            and signal.getsignal(number) is _end_contexts
        ):
            signal.signal(number, _previous[number])


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Return the signals that end any context at present."""
    heeded = SignalHandlerOptions.NO
    for option in (SignalHandlerOptions.SIGINT, SignalHandlerOptions.SIGTERM):
        (number,) = _SIGNALS[option]
        if _contexts[number]:
            heeded = SignalHandlerOptions(heeded | option)
    return heeded


def _end_contexts(signum: int, frame: FrameType | None) -> None:
    if is_swallowed(frame):
        # An exception raised here would be lost: send the signal again after the call.
        resend_signal(signum)
        return
    previous = _previous[signum]
    running = [context for context in tuple(_contexts[signum]) if context.ok()]
    if not running:
        # No context is left to end: call the previous handler.
        signal.signal(signum, previous)
        signal.raise_signal(signum)
        return
    for context in running:
        context.end_by_signal()
    if callable(previous):
        previous(signum, frame)
