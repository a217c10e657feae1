"""Printing the transform between two frames repeatedly, as ``tf2_echo`` does."""

import threading
import time
from collections.abc import Callable

from teleopctl.base.printable import printable_line
from teleopctl.errors import existing_names_hint
from teleopctl.interfaces import split
from teleopctl.node import Duration, Node
from teleopctl.tf.buffer import Buffer
from teleopctl.tf.errors import TransformException
from teleopctl.tf.listener import TransformListener
from teleopctl.tf.live_buffer import LiveBuffer
from teleopctl.tf.transforms import ECHO_DIGITS, Transform, pose_text

# Existing transforms arrive within this time; a missing one is reported only afterwards.
_FIRST_WAIT = Duration(seconds=0.25)
_WAIT = Duration(seconds=1.0)


def echo_text(stamp: int, transform: Transform, digits: int = ECHO_DIGITS) -> str:
    """Return a transform as the lines that ``tf2_echo`` prints: translation, rotation, matrix.

    Args:
        stamp: Time of the transform in nanoseconds; 0 for a static transform.
        transform: Transform between the two frames.
        digits: Number of decimals.
    """
    return f"At time {time_text(stamp)}\n{pose_text(transform, digits)}"


def time_text(stamp: int) -> str:
    """Return a stamp in nanoseconds as text in seconds with nine decimals; ``0.0`` for stamp 0."""
    seconds, nanoseconds = split(stamp)
    return f"{seconds}.{nanoseconds:09d}" if stamp else "0.0"


def echo_transforms(
    node: Node,
    target: str,
    source: str,
    *,
    period_s: float,
    once: bool,
    stamp: int = 0,
    show: Callable[[int, Transform], None],
    fail: Callable[[str], None],
    wait: Callable[[str], object],
) -> None:
    """Look up a transform periodically and pass it to ``show``, until the context ends.

    Args:
        node: Node that subscribes to the transforms; need not be spun.
        target: Frame in which the source frame is expressed.
        source: Frame whose pose is looked up.
        period_s: Seconds between two lookups.
        once: Whether to stop after the first transform.
        stamp: Time of the transform in nanoseconds; 0 for the newest one at each lookup.
        show: Called with stamp and transform after each lookup.
        fail: Called with the text to print when a lookup fails.
        wait: Called each second with the line to print, until the frames are connected.
    """
    buffer = LiveBuffer(node=node)
    listener = TransformListener(buffer, node)
    ended = threading.Event()
    node.context.on_shutdown(ended.set)
    try:
        if not wait_for_frames(buffer, target, source, ended, wait):
            return
        deadline = time.monotonic()
        while not ended.is_set():
            try:
                show(*buffer.lookup(target, source, stamp))
                if once:
                    return
            except TransformException as error:
                now_s = node.get_clock().nanoseconds() * 1e-9
                fail(
                    f"Failure at {now_s:.3f}\nException thrown:{error.message}\n"
                    f"The current list of frames is:\n{buffer.all_frames_as_string()}"
                )
            deadline += period_s
            ended.wait(max(0.0, deadline - time.monotonic()))
    finally:
        node.context.forget_on_shutdown(ended.set)
        listener.unregister()


def wait_for_frames(
    buffer: Buffer,
    target: str,
    source: str,
    ended: threading.Event,
    wait: Callable[[str], object],
) -> bool:
    """Wait until two frames are connected; return True, or False if ``ended`` was set first.

    Args:
        buffer: Buffer of the frames.
        target: Frame in which the source frame is expressed.
        source: Frame whose pose is looked up.
        ended: Event that ends the waiting.
        wait: Called each second with the line to print.
    """
    timeout = _FIRST_WAIT
    patience_ends = time.monotonic() + 1.0
    while not ended.is_set():
        known, reason = buffer.can_transform(
            target, source, 0, timeout=timeout, return_debug_tuple=True
        )
        if known:
            return True
        if not ended.is_set():
            wait(printable_line(f"Waiting for transform {target} ->  {source}: {reason}"))
            if patience_ends and time.monotonic() > patience_ends:
                patience_ends = 0.0
                if text := _unknown_frames(buffer, target, source):
                    wait(printable_line(text))
        timeout = _WAIT
    return False


def _unknown_frames(buffer: Buffer, *names: str) -> str:
    """Return a line that lists the known frames if a name is unknown, else an empty string."""
    known = buffer.frame_names()
    unknown = [name for name in dict.fromkeys(names) if name not in known]
    if not unknown:
        return ""
    listed = " and ".join(f"'{name}'" for name in unknown)
    return f"No frame {listed} yet. {existing_names_hint('frames', unknown, known)}"
