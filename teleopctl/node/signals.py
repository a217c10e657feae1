"""SIGTERM ends the contexts of the process, so that whoever spins tidies up and leaves.

Ctrl-C is left as Python has it: it raises KeyboardInterrupt in the main thread.
"""

from __future__ import annotations

import enum
import signal
import threading
from types import FrameType
from typing import Protocol


class Endable(Protocol):
    """A context, as far as a signal is concerned."""

    def ok(self) -> bool:
        """Whether it runs."""

    def end_by_signal(self) -> None:
        """End it."""


_contexts: set[Endable] = set()
_previous: signal._HANDLER = signal.SIG_DFL


class SignalHandlerOptions(enum.IntEnum):
    """Which signals a context heeds, as ``rclpy.signals`` names them."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3


def heed(context: Endable) -> None:
    """Have SIGTERM end a context; without effect outside the main thread."""
    global _previous
    if threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(signal.SIGTERM) is not _end_contexts:
        _previous = signal.signal(signal.SIGTERM, _end_contexts)
    _contexts.add(context)


def forget(context: Endable) -> None:
    """Take a context back; with the last one goes the handler."""
    _contexts.discard(context)
    if (
        not _contexts
        and threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGTERM) is _end_contexts
    ):
        signal.signal(signal.SIGTERM, _previous)


def _end_contexts(signum: int, frame: FrameType | None) -> None:
    running = [context for context in tuple(_contexts) if context.ok()]
    if not running:
        # Nobody heeded the first one, or there is nobody to heed: what it did before us.
        signal.signal(signum, _previous)
        signal.raise_signal(signum)
        return
    for context in running:
        context.end_by_signal()
    if callable(_previous):
        _previous(signum, frame)
