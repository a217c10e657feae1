"""Cursor over the messages of the played bags, which are read ahead on a thread."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from collections.abc import Callable, Iterator

from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.outputs import PlayerOutputs
from teleopctl.bag.player.playback_time import PlaybackClock, PlaybackTime
from teleopctl.bag.player.source import PlayedBags
from teleopctl.bag.records import BagMessage
from teleopctl.errors import TeleopctlError

MOST_BYTES = 256 * 2**20
"""Largest total size of the messages read ahead; a thousand images would be gigabytes."""


class ReadAhead:
    """Queue of messages that a thread reads ahead, limited in count and bytes.

    Args:
        messages: Messages to read.
        on_arrival: Called when a message is added to the empty queue, and at the end.
        most: Largest number of queued messages.
        most_bytes: Total size of queued messages in bytes at which reading pauses; one message may
            exceed the size.
    """

    def __init__(
        self,
        messages: Iterator[BagMessage],
        on_arrival: Callable[[], object],
        most: int,
        most_bytes: int = MOST_BYTES,
    ) -> None:
        self._messages = messages
        self._on_arrival = on_arrival
        self._most = most
        self._most_bytes = most_bytes
        self._queue: deque[BagMessage] = deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._has_ended = False
        self._is_closed = False
        self._is_refilling = True
        self._failure: TeleopctlError | None = None
        self._thread = threading.Thread(target=self._read, name="bag-read-ahead", daemon=True)
        self._thread.start()

    def peek(self) -> BagMessage | None:
        """Return the oldest queued message, without removing it; None if none is read yet.

        Raises:
            TeleopctlError: The bag cannot be read further.
        """
        if self._queue:
            return self._queue[0]
        if self._failure is not None:
            raise self._failure
        return None

    def discard_oldest(self) -> None:
        """Remove the oldest message; let the thread refill a queue that is half empty."""
        with self._changed:
            self._bytes -= len(self._queue.popleft().data)
            # Not for each message: waking the reading thread would delay the publishing.
            if not self._is_refilling and (
                len(self._queue) <= self._most // 2 and self._bytes <= self._most_bytes // 2
            ):
                self._is_refilling = True
                self._changed.notify_all()

    @property
    def has_ended(self) -> bool:
        """Whether all messages of the bag were read and removed from the queue."""
        return self._has_ended and not self._queue

    def wait_until_filled(self, longest_s: float | None = None) -> None:
        """Wait until the queue is full, everything was read, or a time limit is over.

        Args:
            longest_s: Longest wait in seconds of wall time; None for no limit.
        """
        with self._changed:
            self._changed.wait_for(
                lambda: self._has_ended or self._is_closed or not self._is_refilling, longest_s
            )

    def close(self) -> None:
        """Stop the reading thread, and wait for its end."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        self._thread.join()

    def _read(self) -> None:
        try:
            for message in self._messages:
                if not self._put(message):
                    return
        except TeleopctlError as error:
            self._failure = error
        finally:
            with self._changed:
                self._has_ended = True
                self._changed.notify_all()
            self._on_arrival()

    def _put(self, message: BagMessage) -> bool:
        """Add a message, and wait while the queue is full; return False after `close`."""
        with self._changed:
            self._queue.append(message)
            self._bytes += len(message.data)
            was_empty = len(self._queue) == 1
            if len(self._queue) >= self._most or self._bytes >= self._most_bytes:
                self._is_refilling = False
                self._changed.notify_all()
        if was_empty:
            self._on_arrival()
        if not self._is_refilling:
            with self._changed:
                self._changed.wait_for(lambda: self._is_refilling or self._is_closed)
        return not self._is_closed


def order_by_publish_time(
    messages: Iterator[BagMessage], most: int, most_bytes: int = MOST_BYTES
) -> Iterator[BagMessage]:
    """Yield messages sorted by publish time within a window of `most` messages.

    A message that was received more than a window later than messages published after it stays out
    of order.

    Args:
        messages: Messages in the order of receipt.
        most: Size of the window in messages.
        most_bytes: Largest size of the window in bytes.
    """
    waiting: list[tuple[int, int, BagMessage]] = []
    held = 0
    for number, message in enumerate(messages):
        # The number keeps messages with equal times in the order of receipt.
        heapq.heappush(waiting, (message.publish_time_ns, number, message))
        held += len(message.data)
        while len(waiting) > most or held > most_bytes:
            earliest = heapq.heappop(waiting)[2]
            held -= len(earliest.data)
            yield earliest
    while waiting:
        yield heapq.heappop(waiting)[2]


class MessageCursor:
    """Read position in the messages of the played bags, which publishes them one by one.

    Args:
        source: Bags to read.
        playback_time: Playback time, which `jump_to` sets.
        outputs: Publishers and service clients for the messages.
        clock: Publisher of ``/clock``.
        options: Options with the order of messages and the size of the queue.
        on_warning: Called with a sentence for each broken part of a bag.
        on_published: Called with each published message.

    Attributes:
        until_ns: Time of the last message to publish, in nanoseconds since the epoch; -1 for no
            limit.
        position_ns: Time of the last published message, or of the last jump if that was later, in
            nanoseconds since the epoch.
    """

    def __init__(
        self,
        source: PlayedBags,
        playback_time: PlaybackTime,
        outputs: PlayerOutputs,
        clock: PlaybackClock,
        options: PlayOptions,
        on_warning: Callable[[str], object],
        on_published: Callable[[BagMessage], object],
    ) -> None:
        self._source = source
        self._playback_time = playback_time
        self._outputs = outputs
        self._clock = clock
        self._is_by_sent_time = options.message_order == "sent"
        self._read_ahead = options.read_ahead
        self._on_warning = on_warning
        self._on_published = on_published
        self._queue: ReadAhead | None = None
        self.until_ns = -1
        self.position_ns = playback_time.now_ns()

    def jump_to(self, time_ns: int, read_ahead_s: float = 0.0) -> None:
        """Move reading and playback time to a time; publish latched topics' last earlier messages.

        Args:
            time_ns: Playback time to jump to, in nanoseconds since the epoch.
            read_ahead_s: Longest wait for the first messages to be read, in seconds.
        """
        self.close()
        # Before the reading thread starts to read the files.
        latched = self._source.latched_before(self._outputs.topics, time_ns)
        messages = self._source.messages(self._outputs.topics, time_ns, self._on_warning)
        if self._is_by_sent_time:
            messages = order_by_publish_time(messages, self._read_ahead)
        self._queue = ReadAhead(messages, self._playback_time.wake, self._read_ahead)
        if read_ahead_s:
            self._queue.wait_until_filled(read_ahead_s)
        self.position_ns = time_ns
        self._playback_time.jump(time_ns)
        self._clock.publish()
        for message in latched:
            self._send(message)

    def peek(self) -> tuple[BagMessage | None, bool]:
        """Return the next message without removing it, or None, and whether the end is reached.

        Raises:
            TeleopctlError: The bag cannot be read further.
        """
        assert self._queue is not None
        message = self._queue.peek()
        if message is None:
            return None, self._queue.has_ended
        if 0 <= self.until_ns < self.due_ns(message):
            return None, True
        return message, False

    def send_next(self, message: BagMessage) -> bool:
        """Remove and publish the message that `peek` returned; return whether it was published."""
        assert self._queue is not None
        self._queue.discard_oldest()
        time_ns = self.due_ns(message)
        for split in self._source.splits_between(self.position_ns, time_ns):
            self._outputs.publish_split(split)
        self.position_ns = time_ns
        return self._send(message)

    def due_ns(self, message: BagMessage) -> int:
        """Return the playback time at which a message is to be published, in nanoseconds."""
        return message.publish_time_ns if self._is_by_sent_time else message.log_time_ns

    def close(self) -> None:
        """Stop the thread that reads ahead."""
        if self._queue is not None:
            self._queue.close()
            self._queue = None

    def _send(self, message: BagMessage) -> bool:
        self._clock.publish_before(message.topic)
        is_sent = self._outputs.send(message)
        if is_sent:
            self._on_published(message)
        return is_sent
