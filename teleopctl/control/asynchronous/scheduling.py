"""Scheduling of the control loop and of threads beside it: real-time, else short time slices.

Sources: sched(7); for slices sched_setattr(2) with ``sched_runtime``, which Linux applies to
ordinary threads since 6.12 (Documentation/scheduler/sched-eevdf).
"""

from __future__ import annotations

import contextlib
import os
import platform
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.node import RcutilsLogger
    from teleopctl.robot import AsyncThread

# Real-time priority of the loop's thread, as in ros2_control.
_PRIORITY = 50
# Time slice in nanoseconds, the shortest that Linux grants. A thread that wakes up with it runs
# before a thread of another process that has the usual one (0.7 to 2.8 ms).
_SLICE_NS = 100_000
# Number of the system call sched_setattr, by the machine; Python has no function for it.
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274}


def schedule_control_loop(logger: RcutilsLogger) -> None:
    """Request real-time scheduling for this process; log whether the system permits it.

    The calling thread is that of the loop. The other threads that run now get a priority below its,
    but a real-time one as well: the loop waits for each of them that has the interpreter's lock,
    and must not wait for other processes through it. Threads and processes that they start later,
    such as those of a user's controller, get none: they would keep the system's other processes
    from running.

    Where real-time scheduling is not permitted, all of them get the shortest time slices, for which
    no permission is needed.
    """
    if sys.platform != "linux":
        return
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(_PRIORITY))
    except OSError:
        logger.info("Running without real-time scheduling: the system does not permit it")
        for thread in _threads():
            # A thread may have ended since.
            with contextlib.suppress(OSError):
                _shorten_slice(thread)
        return
    logger.info(f"Successful set up FIFO RT scheduling policy with priority {_PRIORITY}.")
    below = os.sched_param(_PRIORITY - 1)
    # Zenoh's threads too: callbacks run on them.
    for thread in _threads():
        # A thread may have ended since; one may have a priority of its own.
        with contextlib.suppress(OSError):
            if os.sched_getscheduler(thread) == os.SCHED_OTHER:
                os.sched_setscheduler(thread, policy, below)


def schedule_thread(thread: AsyncThread, logger: RcutilsLogger) -> None:
    """Set priority (SCHED_FIFO) and processors of the calling thread; log what is not permitted."""
    if not hasattr(os, "sched_setscheduler"):
        return
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(thread.priority))
    except (OSError, ValueError):
        logger.info(
            f"Running without real-time scheduling: priority {thread.priority} is not permitted"
        )
    if thread.affinity:
        try:
            os.sched_setaffinity(0, thread.affinity)
        except (OSError, ValueError, OverflowError) as error:
            logger.warning(f"Could not set affinity to processors {list(thread.affinity)}: {error}")


def _threads() -> list[int]:
    """Return the system's numbers of this process's threads."""
    return [int(task.name) for task in Path("/proc/self/task").iterdir()]


def _shorten_slice(thread: int) -> None:
    """Give an ordinary thread the shortest time slice; older systems ignore it."""
    import ctypes

    call = _SCHED_SETATTR.get(platform.machine())
    if call is None or os.sched_getscheduler(thread) != os.SCHED_OTHER:
        return

    class SchedAttr(ctypes.Structure):
        """First version of the system's ``struct sched_attr``."""

        _fields_ = (
            ("size", ctypes.c_uint32),
            ("sched_policy", ctypes.c_uint32),
            ("sched_flags", ctypes.c_uint64),
            ("sched_nice", ctypes.c_int32),
            ("sched_priority", ctypes.c_uint32),
            ("sched_runtime", ctypes.c_uint64),
            ("sched_deadline", ctypes.c_uint64),
            ("sched_period", ctypes.c_uint64),
        )

    attributes = SchedAttr(
        size=ctypes.sizeof(SchedAttr),
        sched_policy=os.SCHED_OTHER,
        sched_flags=1,  # SCHED_FLAG_RESET_ON_FORK
        sched_nice=os.getpriority(os.PRIO_PROCESS, thread),
        sched_runtime=_SLICE_NS,
    )
    # An error leaves the thread as it is.
    ctypes.CDLL(None).syscall(call, thread, ctypes.byref(attributes), 0)
