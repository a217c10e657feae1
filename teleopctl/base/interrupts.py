"""SIGINT handling: an interrupt that Python would swallow is raised again.

Python prints and swallows an exception that is raised in a finalizer or in the callback of a weak
reference. Imports run such callbacks, so that Ctrl-C while a program starts may hit one. Zenoh also
swallows exceptions raised in the callbacks that it calls, which may run on the main thread, and so
do extension modules while they are imported: Cython's clear the error of an optional step of theirs
(lxml: two of 300 interrupts of a node that starts on a busy machine).

Python also misses a signal that arrives after the main thread has checked for signals and before it
waits for a lock: the signal is handled only when something else ends the wait. So the main thread
is woken shortly after each signal, with SIGURG, which Go's runtime uses for the same purpose and
other programs hardly ever.

A Python interpreter that is interrupted while it starts, before any code of teleopctl runs, may
swallow the interrupt in such a callback, or end with "Fatal Python error". So child processes are
started with SIGINT blocked until their program calls `install_sigint_handler`.
"""

from __future__ import annotations

import _thread
import os
import sys
import time
from _frozen_importlib_external import ExtensionFileLoader

from teleopctl.base.typed import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import signal
    from collections.abc import Callable
    from sys import UnraisableHookArgs
    from types import CodeType, FrameType
else:
    # The C module behind signal, without the enumerations that take a millisecond to import.
    import _signal as signal

_Function = TypeVar("_Function", bound="Callable[..., object]")

# Delay before an interrupt is raised again. Callbacks of imports and of Zenoh, which must not be
# interrupted, take microseconds, imports of extension modules milliseconds.
_AGAIN_S = 0.001

# Delays before the main thread is woken after a signal, for it to have begun its wait.
_WAKE_AFTER_S = (0.002, 0.02, 0.2)

# Functions below which C code may swallow an exception.
_swallowing: set[CodeType] = {
    ExtensionFileLoader.create_module.__code__,
    ExtensionFileLoader.exec_module.__code__,
}

# Whether KeyboardInterrupt has been raised in the main thread.
_was_raised = False

# Whether a swallowed interrupt is about to be raised again.
_is_pending = False

# Write end of the pipe for signal numbers; empty until `wake_on_signals` has set it.
_wakes: list[int] = []


def transport_callback(function: _Function) -> _Function:
    """Mark a function that Zenoh calls, in which no KeyboardInterrupt may be raised; return it.

    The mark adds no cost to a call.
    """
    _swallowing.add(function.__code__)
    return function


def is_swallowed(frame: FrameType | None) -> bool:
    """Return whether an exception in a frame is lost: in a Zenoh callback or extension import."""
    while frame is not None:
        if frame.f_code in _swallowing:
            return True
        frame = frame.f_back
    return False


def install_sigint_handler() -> None:
    """Install a handler that raises KeyboardInterrupt where it is not swallowed; unblock SIGINT.

    An interrupt that `blocked_for_children` blocked while this process started is raised now.
    """
    signal.signal(signal.SIGINT, _interrupt)
    sys.unraisablehook = _hook(sys.unraisablehook)
    wake_on_signals()
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


# A class, as below, since contextlib takes a millisecond to import.
class blocked_for_children:  # noqa: N801 -- used as a function
    """Block SIGINT in processes started in a ``with`` block until `install_sigint_handler`.

    Only for programs that call it: child processes inherit the mask, and without that call SIGINT
    would never interrupt them.
    """

    def __enter__(self) -> None:
        if sys.platform != "win32":
            self._before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

    def __exit__(self, *_: object) -> None:
        if sys.platform != "win32":
            signal.pthread_sigmask(signal.SIG_SETMASK, self._before)


# Any: arguments of `subprocess.Popen` have many types.
def own_group() -> dict[str, Any]:
    """Return `subprocess.Popen` arguments that keep the terminal's Ctrl-C from a process.

    The process that starts it sends the signals itself, in order.
    """
    if sys.platform == "win32":
        import subprocess

        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"process_group": 0}


class delayed_interrupt:  # noqa: N801 -- used as a function
    """Delay a SIGINT that arrives during a ``with`` block until its end.

    Use it where an interrupt would lose a reference, such as that to a process just started. A
    signal mask would not be enough, since the system may deliver the signal to a thread of Zenoh.
    """

    def __enter__(self) -> None:
        self._came: list[int] = []
        try:
            self._before = signal.signal(
                signal.SIGINT, lambda signum, _frame: self._came.append(signum)
            )
        except ValueError:
            self._before = None  # not the main thread, which alone is interrupted

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
        if self._came:
            signal.raise_signal(signal.SIGINT)


def wake_on_signals() -> None:
    """Make each signal from now on end lock waits of the main thread, which must call this.

    Does nothing if the program has set a wakeup descriptor itself (`signal.set_wakeup_fd`).
    """
    if sys.platform == "win32" or _wakes:
        return
    read_end, write_end = os.pipe()
    os.set_blocking(write_end, False)
    others = signal.set_wakeup_fd(write_end, warn_on_full_buffer=False)
    if others != -1:
        signal.set_wakeup_fd(others)
        os.close(read_end)
        os.close(write_end)
        return
    _wakes.append(write_end)
    signal.signal(signal.SIGURG, _woken)
    _thread.start_new_thread(_wake, (read_end, _thread.get_ident()))


def _woken(_signum: int, _frame: FrameType | None) -> None:
    """Handle SIGURG, whose arrival alone ends a wait."""


def _wake(read_end: int, thread: int) -> None:
    while numbers := os.read(read_end, 64):
        if all(number == signal.SIGURG for number in numbers):
            continue
        for wait_s in _WAKE_AFTER_S:
            time.sleep(wait_s)
            # A program may have set a handler of its own for SIGURG.
            if signal.getsignal(signal.SIGURG) is _woken:
                signal.pthread_kill(thread, signal.SIGURG)


def resend_signal(signum: int = signal.SIGINT) -> None:
    """Send a signal again to the main thread, which must be the caller, after a millisecond."""
    global _is_pending
    _is_pending = _is_pending or signum == signal.SIGINT
    # Not a threading.Thread: its start takes a lock, which the interrupted code may hold.
    _thread.start_new_thread(_signal, (signum, _thread.get_ident()))


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt if one was raised in this process before, even if it was caught.

    Call it where an interrupt should have ended the program earlier: user code or a library may
    have caught the exception (``except:``).

    Raises:
        KeyboardInterrupt: An interrupt was raised in this process before.
    """
    if _was_raised:
        raise KeyboardInterrupt


def is_cause(error: BaseException | None) -> bool:
    """Return whether an interrupt caused an exception, or one is about to be raised again.

    Before 3.12 Python wraps an exception that is raised in ``__set_name__`` into a RuntimeError.
    """
    seen: set[int] = set()
    # An exception may be its own cause: ``raise error from error`` in a user's file.
    while error is not None and id(error) not in seen:
        if isinstance(error, KeyboardInterrupt):
            return True
        seen.add(id(error))
        error = error.__cause__
    return _is_pending


def clear_exec_interrupt() -> None:
    """Clear Python's mark that an interrupt passed through ``exec`` or ``eval``.

    With that mark, CPython ends the process by SIGINT instead of with its exit status, whatever the
    program does after the interrupt. The next call of ``exec`` clears the mark.
    """
    exec("")  # noqa: S102


def _interrupt(signum: int, frame: FrameType | None) -> None:
    global _is_pending, _was_raised
    if is_swallowed(frame):
        resend_signal()
    else:
        _was_raised, _is_pending = True, False
        signal.default_int_handler(signum, frame)


def _hook(
    before: Callable[[UnraisableHookArgs], object],
) -> Callable[[UnraisableHookArgs], None]:
    def hook(unraisable: UnraisableHookArgs) -> None:
        if unraisable.exc_type is KeyboardInterrupt:
            resend_signal()
        else:
            before(unraisable)

    return hook


def _signal(signum: int, thread: int) -> None:
    time.sleep(_AGAIN_S)
    if signal.getsignal(signum) == signal.SIG_DFL:
        return  # the program is ending, and SIGINT would change its exit status
    if sys.platform == "win32":
        _thread.interrupt_main(signum)
    else:
        # Only a real signal ends a wait for a lock.
        signal.pthread_kill(thread, signum)
