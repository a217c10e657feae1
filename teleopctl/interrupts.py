"""An interrupt that cannot be raised where it comes, or that Python swallows, is raised again.

Python reports what is raised in a finalizer or a weak reference's callback, and forgets it. Its
imports have such callbacks, so that Ctrl-C while a program starts may meet one. Zenoh does the same
with what is raised in the functions that it calls, on whichever thread makes something known, which
may be the main thread.
"""

from __future__ import annotations

import _thread
import signal
import sys
import time
from collections.abc import Callable
from types import CodeType, FrameType
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

_Function = TypeVar("_Function", bound=Callable[..., object])

# What an interrupt must not meet, callbacks of imports or calls from Zenoh, lasts microseconds.
_AGAIN_S = 0.001

_transport_callbacks: set[CodeType] = set()


def transport_callback(function: _Function) -> _Function:
    """Mark a function that Zenoh calls: no interrupt is raised in it. Costs nothing in the call."""
    _transport_callbacks.add(function.__code__)
    return function


def in_transport_callback(frame: FrameType | None) -> bool:
    """Whether a frame belongs to a call from Zenoh."""
    while frame is not None:
        if frame.f_code in _transport_callbacks:
            return True
        frame = frame.f_back
    return False


def take() -> None:
    """Have every SIGINT raise KeyboardInterrupt in the main thread, be it a moment later."""
    signal.signal(signal.SIGINT, _interrupt)
    sys.unraisablehook = _hook(sys.unraisablehook)


def come_again(signum: int = signal.SIGINT) -> None:
    """Have a signal come once more, in a moment, to the main thread, which is to call this."""
    # Not a threading.Thread: its start takes a lock, which the interrupted code may be holding.
    _thread.start_new_thread(_signal, (signum, _thread.get_ident()))


def _interrupt(signum: int, frame: FrameType | None) -> None:
    if in_transport_callback(frame):
        come_again()
    else:
        signal.default_int_handler(signum, frame)


def _hook(
    before: Callable[[UnraisableHookArgs], object],
) -> Callable[[UnraisableHookArgs], None]:
    def hook(unraisable: UnraisableHookArgs) -> None:
        if unraisable.exc_type is KeyboardInterrupt:
            come_again()
        else:
            before(unraisable)

    return hook


def _signal(signum: int, thread: int) -> None:
    time.sleep(_AGAIN_S)
    if sys.platform == "win32":
        _thread.interrupt_main(signum)
    else:
        # A real signal, for only that ends a wait for a lock.
        signal.pthread_kill(thread, signum)
