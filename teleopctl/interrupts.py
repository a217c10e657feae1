"""An interrupt that cannot be raised where it comes, or that Python swallows, is raised again.

Python reports what is raised in a finalizer or a weak reference's callback, and forgets it. Its
imports have such callbacks, so that Ctrl-C while a program starts may meet one.
"""

from __future__ import annotations

import _thread
import signal
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

# What an interrupt must not meet, callbacks of imports or calls from Zenoh, lasts microseconds.
_AGAIN_S = 0.001


def come_again(signum: int = signal.SIGINT) -> None:
    """Have a signal come once more, in a moment, to the main thread, which is to call this."""
    # Not a threading.Thread: its start takes a lock, which the interrupted code may be holding.
    _thread.start_new_thread(_signal, (signum, _thread.get_ident()))


def raise_swallowed_again() -> None:
    """Have every KeyboardInterrupt that Python swallows in the main thread come once more."""
    sys.unraisablehook = _hook(sys.unraisablehook)


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
