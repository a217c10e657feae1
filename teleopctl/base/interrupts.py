"""SIGINT handling: an interrupt that Python would swallow is raised again.

Python reports what is raised in a finalizer or a weak reference's callback, and forgets it. Its
imports have such callbacks, so that Ctrl-C while a program starts may meet one. Zenoh does the same
with what is raised in the functions that it calls, on whichever thread makes something known, which
may be the main thread.

Nor does Python see a signal that comes when the main thread has just looked for signals and is
about to wait for a lock: it would be heard when something else ends the wait. So the main thread is
woken a moment after each signal, with the one that Go's runtime uses for the like, since nobody
else does.

A Python interpreter that is interrupted while it starts, before a line of ours runs, may forget the
interrupt in such a callback, or end with "Fatal Python error". So what is started here keeps SIGINT
blocked until its program calls `take`.
"""

from __future__ import annotations

import _thread
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType

from teleopctl.base.typed import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import signal
    from sys import UnraisableHookArgs
else:
    # What stands behind it, without the enumerations that take a millisecond to import.
    import _signal as signal

_Function = TypeVar("_Function", bound=Callable[..., object])

# What an interrupt must not meet, callbacks of imports or calls from Zenoh, lasts microseconds.
_AGAIN_S = 0.001

# After each of these the main thread will have got from its last look to its wait, if it ever will.
_WAKE_AFTER_S = (0.002, 0.02, 0.2)

_transport_callbacks: set[CodeType] = set()

# Whether KeyboardInterrupt has been raised, which ends most programs.
_was_raised = False

# Whether an interrupt is to be raised again that was swallowed.
_is_pending = False

# What signals are written to, once the main thread is woken after them.
_wakes: list[int] = []


def transport_callback(function: _Function) -> _Function:
    """Mark a function that Zenoh calls, in which no KeyboardInterrupt may be raised.

    Costs nothing in the call.
    """
    _transport_callbacks.add(function.__code__)
    return function


def in_transport_callback(frame: FrameType | None) -> bool:
    """Return whether a frame belongs to a callback of Zenoh."""
    while frame is not None:
        if frame.f_code in _transport_callbacks:
            return True
        frame = frame.f_back
    return False


def take() -> None:
    """Install the SIGINT handler: KeyboardInterrupt in the main thread, at a safe place.

    One that came while this process started, and that `blocked_for_children` kept back, comes now.
    """
    signal.signal(signal.SIGINT, _interrupt)
    sys.unraisablehook = _hook(sys.unraisablehook)
    end_waits()
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


@contextmanager
def blocked_for_children() -> Iterator[None]:
    """Block SIGINT in child processes started in the block, until they call `take`.

    Only for programs that do so: the mask is inherited, and others would never be interrupted.
    """
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def delayed_interrupt() -> Iterator[None]:
    """Delay an interrupt until the end of the block.

    For what must be known before it may be given up, such as a process that has just been started.
    A mask would not do, since the system may hand the signal to a thread of Zenoh's.
    """
    came: list[int] = []
    try:
        before = signal.signal(signal.SIGINT, lambda signum, _frame: came.append(signum))
    except ValueError:
        before = None  # interrupts are the main thread's, and this is another one
    try:
        yield
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


def end_waits() -> None:
    """Make signals end the main thread's waits; must be called from that thread.

    Where a program listens to signals itself (`signal.set_wakeup_fd`), it is left alone.
    """
    if sys.platform == "win32" or _wakes:
        return
    signals, heard = os.pipe()
    os.set_blocking(heard, False)
    others = signal.set_wakeup_fd(heard, warn_on_full_buffer=False)
    if others != -1:
        signal.set_wakeup_fd(others)
        os.close(signals)
        os.close(heard)
        return
    _wakes.append(heard)
    signal.signal(signal.SIGURG, _woken)
    _thread.start_new_thread(_wake, (signals, _thread.get_ident()))


def _woken(_signum: int, _frame: FrameType | None) -> None:
    """Be a reason for a wait to end."""


def _wake(signals: int, thread: int) -> None:
    while numbers := os.read(signals, 64):
        if all(number == signal.SIGURG for number in numbers):
            continue
        for wait_s in _WAKE_AFTER_S:
            time.sleep(wait_s)
            # A program may have a use of its own for it.
            if signal.getsignal(signal.SIGURG) is _woken:
                signal.pthread_kill(thread, signal.SIGURG)


def resend_signal(signum: int = signal.SIGINT) -> None:
    """Raise a signal again in the main thread, which must be the caller."""
    global _is_pending
    _is_pending = _is_pending or signum == signal.SIGINT
    # Not a threading.Thread: its start takes a lock, which the interrupted code may be holding.
    _thread.start_new_thread(_signal, (signum, _thread.get_ident()))


def raise_swallowed() -> None:
    """Raise an interrupt again that was swallowed.

    To be called where an interrupt would have ended the program before: a user's code may have
    caught it (``except:``), and a library may have.

    Raises:
        KeyboardInterrupt: There was one.
    """
    if _was_raised:
        raise KeyboardInterrupt


def is_cause(error: BaseException | None) -> bool:
    """Return whether an exception was caused by an interrupt, or came before one was raised again.

    Before 3.12 Python wraps what is raised while a class takes its attributes (``__set_name__``)
    into a RuntimeError.
    """
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__
    return _is_pending


def clear_exec_interrupt() -> None:
    """Clear Python's mark that an interrupt passed through ``exec`` or ``eval``.

    CPython keeps a mark from there on, and whatever the program does then, it kills itself by
    SIGINT where it would have ended with its status. The next text that is run takes it back.
    """
    exec("")  # noqa: S102


def _interrupt(signum: int, frame: FrameType | None) -> None:
    global _is_pending, _was_raised
    if in_transport_callback(frame):
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
        return  # the program has come to its end meanwhile, and would not end as it says
    if sys.platform == "win32":
        _thread.interrupt_main(signum)
    else:
        # A real signal, for only that ends a wait for a lock.
        signal.pthread_kill(thread, signum)
