"""An interrupt that Python swallows is raised again.

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

# The callbacks of imports last some microseconds.
_AGAIN_S = 0.001


def raise_swallowed_again() -> None:
    """Have every KeyboardInterrupt that Python swallows in the main thread come once more."""
    sys.unraisablehook = _hook(sys.unraisablehook, _thread.get_ident())


def _hook(
    before: Callable[[UnraisableHookArgs], object], main_thread: int
) -> Callable[[UnraisableHookArgs], None]:
    def come_again() -> None:
        time.sleep(_AGAIN_S)
        if sys.platform == "win32":
            _thread.interrupt_main()
        else:
            # A real signal, for only that ends a wait for a lock.
            signal.pthread_kill(main_thread, signal.SIGINT)

    def hook(unraisable: UnraisableHookArgs) -> None:
        if unraisable.exc_type is KeyboardInterrupt:
            _thread.start_new_thread(come_again, ())
        else:
            before(unraisable)

    return hook
