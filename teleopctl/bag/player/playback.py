"""Playing bags into the graph, with the behaviour of rosbag2's player."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from teleopctl.bag.base import Bag
from teleopctl.bag.player.cursor import MessageCursor
from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.outputs import PlayerOutputs
from teleopctl.bag.player.playback_time import CLOCK, PlaybackClock, PlaybackTime
from teleopctl.bag.player.source import PlayedBags
from teleopctl.bag.records import BagMessage
from teleopctl.wire import wait_for_peer_tokens

if TYPE_CHECKING:
    from teleopctl.node import Node

# Longest delay of the start by reading ahead from a slow disk.
_LONGEST_FILL_S = 0.5
_WARN_EVERY_S = 1.0

BagPath: TypeAlias = str | Path | tuple[str | Path, str | None] | Bag
"""Path of a bag, a pair of path and storage format (None to detect the format), or an open bag."""


class _Request:
    """Function that the playing thread calls between two messages, with its result."""

    def __init__(self, work: Callable[[], int]) -> None:
        self.work = work
        self.done = threading.Event()
        self.result = 0


class Playback:
    """Playback of bags merged by time, with the methods of rosbag2's player; thread-safe.

    Args:
        node: Node that publishes, owned by the caller. Remappings of the node apply.
        bags: Path of a bag, or several paths.
        options: Options of the playback.
        on_published: Called on the playing thread with each published message.

    Attributes:
        start_ns: Start of the playback, in nanoseconds since the epoch.
        end_ns: Log time of the last message, in nanoseconds since the epoch.
        loops: Whether the playback starts again at the end. One that has been started with
            ``loop``, and loops no longer, pauses at the end; it starts again when it is resumed.

    Raises:
        NotFoundError: A bag does not exist.
        InvalidFileError: A bag cannot be read.
    """

    def __init__(
        self,
        node: Node,
        bags: str | Path | Sequence[BagPath],
        options: PlayOptions,
        on_published: Callable[[BagMessage], object],
    ) -> None:
        self._node = node
        self._options = options
        self.loops = options.loop
        self._log = node.get_logger()
        self._source = PlayedBags(_paths(bags))
        for remark in self._source.remarks:
            self._log.warning(remark)
        topics = [
            topic
            for topic in self._source.topics.values()
            # A recorded /clock would conflict with the published one.
            if not (options.clock_hz and topic.name == CLOCK)
        ]
        try:
            self._outputs = PlayerOutputs(node, topics, options)
        except BaseException:
            self._source.close()
            raise
        self.start_ns = self._source.start_ns + options.start_offset_ns
        self.end_ns = self._source.end_ns
        self._playback_time = PlaybackTime(self.start_ns, is_paused=options.is_paused)
        self._clock = PlaybackClock(node, self._playback_time, options)
        self._cursor = MessageCursor(
            self._source,
            self._playback_time,
            self._outputs,
            self._clock,
            options,
            self._log.warning,
            on_published,
        )
        self._cursor.until_ns = self._until(options.duration_ns, options.until_ns)
        self._requests: deque[_Request] = deque()
        self._stopping = threading.Event()
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._is_playing = False
        self._is_bursting = False
        self._is_delayed = False
        self._failure: BaseException | None = None
        self._next_warning_s = 0.0
        self.set_rate(options.rate)
        node.context.on_shutdown(self._request_stop)

    # -- control ---------------------------------------------------------------------------------

    def play(self) -> bool:
        """Start playing on a thread; return False with a warning if already playing."""
        with self._changed:
            if self._is_playing:
                self._log.warning("Trying to play() while in playback, dismissing request.")
                return False
            self._is_playing = True
            self._failure = None
            self._stopping.clear()
            self._thread = threading.Thread(target=self._run, name="bag-player", daemon=True)
        self._log.info(f"Playback until timestamp: {self._cursor.until_ns}")
        self._thread.start()
        return True

    def play_from(self, start_ns: int, duration_ns: int | None, until_ns: int | None) -> bool:
        """Start playing from an offset for a duration or until a time; return False if playing.

        Args:
            start_ns: Start of the playback, in nanoseconds after the bag's start.
            duration_ns: Duration of the playback in the bag's time, in nanoseconds; None for all.
            until_ns: End of the playback, in nanoseconds since the epoch; None for all.
        """
        if not self._is_playing:
            self.start_ns = self._source.start_ns + start_ns
            self._cursor.until_ns = self._until(duration_ns, until_ns)
        return self.play()

    def stop(self) -> bool:
        """Stop playing and wait for the end; return False if not playing."""
        if not self._is_playing:
            return False
        self._log.info("Stopping playback.")
        self._request_stop()
        self.wait()
        return True

    def pause(self) -> None:
        """Pause the playback time, and with it the publishing."""
        self._playback_time.pause()
        self._log.info("Pausing play.")

    def resume(self) -> None:
        """Resume the playback time."""
        self._playback_time.resume()
        self._log.info("Resuming play.")

    def toggle_paused(self) -> None:
        """Pause the playback time, or resume it if it is paused."""
        if self.is_paused:
            self.resume()
        else:
            self.pause()

    def set_rate(self, rate: float) -> bool:
        """Set the playback rate; return False with a warning for 0 or less."""
        if not self._playback_time.set_rate(rate):
            self._log.warning(f"Failed to set rate to invalid value {rate:g}")
            return False
        self._log.info(f"Set rate to {rate:g}")
        return True

    def play_next(self) -> bool:
        """Publish the next message while paused; return False if not paused or at the end."""
        if not self._is_playing:
            self._log.warning("Called play next, but player is not playing.")
            return False
        if not self.is_paused:
            self._log.warning("Called play next, but not in paused state.")
            return False
        return self._run_on_thread(lambda: self._burst(1)) == 1

    def burst(self, most: int = 0) -> int:
        """Publish up to `most` messages at once while paused (0: all); return their number.

        Args:
            most: Largest number of messages; 0 for all remaining ones.
        """
        if not self.is_paused:
            self._log.warning("Burst can only be used when in the paused state.")
            return 0
        self._is_bursting = True
        sent = self._run_on_thread(lambda: self._burst(most))
        self._is_bursting = False
        self._log.info(f"Burst {sent} messages.")
        return sent

    def seek(self, time_ns: int) -> bool:
        """Jump to a time and publish latched topics' last messages; return False if not playing.

        Args:
            time_ns: Time to jump to, in nanoseconds since the epoch, but not before `start_ns`.
        """
        if not self._is_playing:
            self._log.warning("Called seek, but player is not playing.")
            return False

        def jump() -> int:
            self._cursor.jump_to(max(time_ns, self.start_ns))
            return 1

        return self._run_on_thread(jump) == 1

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for the end of the playback, and raise its error; return False after the timeout.

        Args:
            timeout_s: Longest wait in seconds of wall time; None for no limit.

        Raises:
            TeleopctlError: The bag could not be read to its end.
        """
        with self._changed:
            has_ended = self._changed.wait_for(lambda: not self._is_playing, timeout_s)
        if has_ended and self._failure is not None:
            raise self._failure
        return has_ended

    # -- state -----------------------------------------------------------------------------------

    @property
    def is_playing(self) -> bool:
        """Whether a playback is running, paused or not."""
        return self._is_playing

    @property
    def is_paused(self) -> bool:
        """Whether the playback time is paused."""
        return self._playback_time.is_paused

    @property
    def is_bursting(self) -> bool:
        """Whether `burst` is publishing messages now."""
        return self._is_bursting

    @property
    def is_delayed(self) -> bool:
        """Whether the player is waiting for its start delay."""
        return self._is_delayed

    @property
    def rate(self) -> float:
        """Playback rate: seconds of the bag per second of wall time."""
        return self._playback_time.rate

    @property
    def position_ns(self) -> int:
        """Bag time in nanoseconds of the last published message, or of a later jump."""
        return self._cursor.position_ns

    def close(self) -> None:
        """Stop, close the bags, and destroy the player's publishers and service clients."""
        self._node.context.forget_on_shutdown(self._request_stop)
        self._request_stop()
        if self._thread is not None and self._thread.ident is not None:
            self._thread.join()
        self._clock.close()
        self._outputs.close()
        self._source.close()

    # -- the playing thread ----------------------------------------------------------------------

    def _run(self) -> None:
        try:
            # Existing subscribers must receive the first message.
            wait_for_peer_tokens(self._node.context.session)
            while not self._delay():
                # Read ahead before the playback time runs, so that the first messages are not late.
                self._cursor.jump_to(self.start_ns, _LONGEST_FILL_S)
                self._clock.start()
                if not self._play_through() or not (self.loops or self._options.loop):
                    break
        except BaseException as error:  # noqa: BLE001 (`wait` raises it)
            # An error after the shutdown of the context is expected.
            if self._node.context.ok():
                self._failure = error
        finally:
            self._cursor.close()
            with self._changed:
                self._is_playing = False
                requests = [*self._requests]
                self._requests.clear()
                self._changed.notify_all()
            for request in requests:
                request.done.set()

    def _delay(self) -> bool:
        """Wait for the delay before a start; return True if the playback is stopped."""
        self._is_delayed = True
        is_to_end = self._stopping.wait(self._options.delay_s)
        self._is_delayed = False
        return is_to_end

    def _play_through(self) -> bool:
        """Play to the end; return False if no message was played."""
        has_played = is_paused_at_end = False
        while not self._stopping.is_set():
            if self._requests:
                request = self._requests.popleft()
                try:
                    request.result = request.work()
                finally:
                    request.done.set()
                continue
            message, has_ended = self._cursor.peek()
            if message is None:
                # A playback that is paused at the end continues, so that `seek` is possible.
                if has_ended and not self.is_paused:
                    if self.loops or not self._options.loop or is_paused_at_end:
                        break
                    is_paused_at_end = True
                    self.pause()
                if not has_ended and has_played:
                    self._warn_of_starving()
                self._playback_time.wait_until(None)
            elif (
                self._playback_time.wait_until(self._cursor.due_ns(message))
                and not self._stopping.is_set()
            ):
                self._cursor.send_next(message)
                has_played, is_paused_at_end = True, False
        return has_played

    def _burst(self, most: int) -> int:
        sent = 0
        while not self._stopping.is_set() and self.is_paused and (not most or sent < most):
            message, has_ended = self._cursor.peek()
            if message is not None:
                self._playback_time.jump(self._cursor.due_ns(message))
                sent += self._cursor.send_next(message)
            elif has_ended:
                break
            else:
                self._playback_time.wait_until(None)
        return sent

    def _warn_of_starving(self) -> None:
        now_s = time.monotonic()
        if now_s >= self._next_warning_s:
            self._next_warning_s = now_s + _WARN_EVERY_S
            self._log.warning(
                "Message queue starved. Messages will be delayed. Consider increasing the "
                "--read-ahead-queue-size option."
            )

    # --------------------------------------------------------------------------------------------

    def _run_on_thread(self, work: Callable[[], int]) -> int:
        """Call a function on the playing thread and return the result; 0 if not playing."""
        request = _Request(work)
        with self._changed:
            if not self._is_playing:
                return 0
            self._requests.append(request)
        self._playback_time.wake()
        request.done.wait()
        return request.result

    def _request_stop(self) -> None:
        self._stopping.set()
        self._playback_time.wake()

    def _until(self, duration_ns: int | None, until_ns: int | None) -> int:
        """Return the time of the last message to play, in ns since the epoch; -1 for no end."""
        # With a duration of 0, no message is played, not even the first.
        ends = [self.start_ns + (duration_ns or -1)] if duration_ns is not None else []
        ends += [until_ns] if until_ns is not None else []
        return max(ends, default=-1)


def _paths(bags: str | Path | Sequence[BagPath]) -> list[tuple[Path, str | None] | Bag]:
    def source(bag: BagPath) -> tuple[Path, str | None] | Bag:
        if isinstance(bag, Bag):
            return bag
        return (Path(bag), None) if isinstance(bag, str | Path) else (Path(bag[0]), bag[1])

    return [source(bag) for bag in ((bags,) if isinstance(bags, str | Path) else bags)]
