"""Writing thread of a recorder, with its message queue and its snapshot buffer."""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, TypeVar

from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.bag.storage.bag_writer import BagWriter
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

# Delay in seconds after which queued messages are written together: waking a thread costs more
# than writing a small message.
_GATHER_S = 0.1

# Number of queued bytes that are written without the delay.
_MUCH_BYTES = 4 * 2**20


class MessageQueue:
    """Queue of messages from the subscriptions to the writing thread, limited in bytes.

    A full queue rejects messages; the caller of `put` counts them.

    Args:
        most_bytes: Largest total size of the messages in bytes; an empty queue accepts a message of
            any size.

    Attributes:
        count: Number of messages accepted so far.
    """

    def __init__(self, most_bytes: int) -> None:
        self.count = 0
        self._most_bytes = most_bytes
        self._messages: deque[BagMessage] = deque()
        self._tasks: deque[Callable[[], object]] = deque()
        self._lock = threading.Lock()
        self._something = threading.Event()
        self._hurry = threading.Event()
        # Size of the queued messages, and of those that were taken but are not written yet.
        self._bytes = 0
        self._is_closed = False

    @property
    def is_closed(self) -> bool:
        """Whether the queue is closed, so that it refuses messages."""
        return self._is_closed

    def put(self, message: BagMessage) -> bool:
        """Add a message from any thread; return False if the queue is full or closed."""
        size = len(message.data)
        with self._lock:
            if self._is_closed or (self._bytes and self._bytes + size > self._most_bytes):
                return False
            self._bytes += size
            self.count += 1
            self._messages.append(message)
            hurry = self._bytes > _MUCH_BYTES
        if not self._something.is_set():
            self._something.set()
        if hurry and not self._hurry.is_set():
            self._hurry.set()
        return True

    def call(self, task: Callable[[], object]) -> bool:
        """Queue a function for the writing thread, after current messages; False if closed."""
        with self._lock:
            if self._is_closed:
                return False
            self._tasks.append(task)
        self._hurry.set()
        self._something.set()
        return True

    def take_all(
        self, longest_s: float
    ) -> tuple[list[BagMessage], list[Callable[[], object]], bool]:
        """Wait for messages or functions; return (messages, functions, whether it is closed).

        Args:
            longest_s: Longest wait in seconds.

        Returns:
            Messages to write, functions to call after that, and whether the queue is closed.
        """
        if self._something.wait(longest_s) and not self._is_closed:
            self._hurry.wait(_GATHER_S)
        with self._lock:
            self._something.clear()
            self._hurry.clear()
            messages, self._messages = list(self._messages), deque()
            tasks, self._tasks = list(self._tasks), deque()
            return messages, tasks, self._is_closed

    def release(self, size: int) -> None:
        """Free the bytes that written messages took of the queue's limit."""
        with self._lock:
            self._bytes -= size

    def close(self) -> None:
        """Close the queue to new messages; queued ones are still written; idempotent."""
        with self._lock:
            self._is_closed = True
        self._hurry.set()
        self._something.set()


_MOST_LATCHED = 100


class SnapshotBuffer:
    """Ring buffer of the newest messages, limited in bytes and in time; not thread-safe.

    The last messages of latched topics are also kept, whatever their age: a robot description is
    published once, and every snapshot needs it.

    Args:
        most_bytes: Largest total size of the messages in bytes; 0 for no limit.
        longest_s: Largest age of a message relative to the newest one, in seconds; 0 for no limit.
    """

    def __init__(self, most_bytes: int, longest_s: float = 0.0) -> None:
        self._most_bytes = most_bytes
        self._longest_ns = round(longest_s * NANOSECONDS_PER_SECOND)
        self._messages: deque[BagMessage] = deque()
        self._bytes = 0
        self._latched: dict[tuple[str, bytes], deque[BagMessage]] = {}
        # Number of dropped old messages by topic, which must not count as lost in the bag.
        self._fallen_out: Counter[str] = Counter()

    def put(self, message: BagMessage, latched_depth: int = 0) -> None:
        """Add a message; keep the last ones of latched topics; drop the oldest others if full.

        Args:
            message: Newest message.
            latched_depth: Number of messages that a late subscriber gets from a publisher of the
                topic; 0 if the topic is not latched.
        """
        if latched_depth:
            key = (message.topic, message.publisher)
            kept = self._latched.setdefault(key, deque(maxlen=min(latched_depth, _MOST_LATCHED)))
            kept.append(message)
        self._messages.append(message)
        self._bytes += len(message.data)
        while self._is_full(message.log_time_ns):
            oldest = self._messages.popleft()
            self._bytes -= len(oldest.data)
            self._fallen_out[oldest.topic] += 1

    def take(self) -> list[BagMessage]:
        """Return and remove the buffered messages, preceded by older ones of latched topics."""
        messages, self._messages, self._bytes = self._messages, deque(), 0
        if not messages:
            return []
        there = {id(message) for message in messages}
        begin_ns = messages[0].log_time_ns
        earlier = [
            message._replace(log_time_ns=begin_ns, sequence=0)
            for kept in self._latched.values()
            for message in kept
            if id(message) not in there
        ]
        recorded = [
            message._replace(sequence=message.sequence - self._fallen_out[message.topic])
            for message in messages
        ]
        return [*earlier, *recorded]

    def _is_full(self, now_ns: int) -> bool:
        if len(self._messages) < 2:
            return False
        if self._most_bytes and self._bytes > self._most_bytes:
            return True
        return bool(self._longest_ns) and now_ns - self._messages[0].log_time_ns > self._longest_ns


# Interval of flushes in seconds: messages of this time are lost if the process is killed.
_FLUSH_S = 0.5

# Interval of fsync calls in seconds: messages of this time are lost if the power fails.
_SYNC_S = 3.0

# Number of written bytes after which the space in the queue is released.
_STEP_BYTES = 2**20

# Number of futures that are cancelled at the end if they have no result yet.
_MOST_ANSWERS = 1000

ResultT = TypeVar("ResultT")


class WritingThread:
    """Thread that writes the messages of a `MessageQueue` to a bag.

    Messages of a topic without a definition are held until `add_topic`.

    Args:
        writer: Writer of the bag, used only by this thread from now on.
        queue: Queue that the messages are taken from.
        snapshot: Buffer that holds the messages until a snapshot is taken; None writes them to the
            bag.
        on_failure: Called once with the error when writing fails; nothing is written after that.
        is_eager: Whether to flush after each write.
    """

    def __init__(
        self,
        writer: BagWriter,
        queue: MessageQueue,
        snapshot: SnapshotBuffer | None,
        on_failure: Callable[[TeleopctlError], object],
        *,
        is_eager: bool = False,
    ) -> None:
        self._writer = writer
        self._queue = queue
        self._snapshot = snapshot
        self._on_failure = on_failure
        self._flush_s = 0.0 if is_eager else _FLUSH_S
        self._flush_due_s = 0.0
        self._is_flushed = True
        self._latched: dict[str, int] = {}
        self._held: dict[str, list[BagMessage]] = {}
        self._failure: TeleopctlError | None = None
        self._answers: deque[Future[Any]] = deque(maxlen=_MOST_ANSWERS)
        self._ended = threading.Event()
        self._threads = [
            threading.Thread(target=target, name=name, daemon=True)
            for target, name in ((self._run, "bag writer"), (self._sync, "bag sync"))
        ]
        for thread in self._threads:
            thread.start()

    def add_topic(self, topic: BagTopic) -> None:
        """Add a topic to the bag, from any thread, and write the messages held for the topic."""
        self._queue.call(lambda: self._add_topic(topic))

    def call(self, function: Callable[[BagWriter], ResultT]) -> Future[ResultT]:
        """Call a function with the bag writer on the writing thread; return a future of the result.

        The future is cancelled if the recording ends before the call.
        """
        answer: Future[ResultT] = Future()

        def run() -> None:
            try:
                answer.set_result(function(self._writer))
            except TeleopctlError as error:
                answer.set_exception(error)
                raise

        self._answers.append(answer)
        if not self._queue.call(run):
            answer.cancel()
        return answer

    def split(self) -> Future[tuple[Path, Path]]:
        """Start a new file of the bag; return a future of the closed and the new file's path."""
        return self.call(lambda writer: writer.split())

    def take_snapshot(self) -> Future[bool]:
        """Write the snapshot buffer to a file of its own; return a future, False without buffer."""
        return self.call(self._write_snapshot)

    def close(self) -> None:
        """Write all queued messages, finish the bag and end the threads; raise earlier errors.

        Raises:
            SystemFailureError: Writing failed, now or before.
        """
        self._queue.close()
        for thread in self._threads:
            thread.join()
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        try:
            self._write_all()
            self._writer.close()
        except TeleopctlError as error:
            self._failure = error
            self._queue.close()
            self._on_failure(error)
        finally:
            self._ended.set()
            for answer in tuple(self._answers):
                answer.cancel()

    def _write_all(self) -> None:
        is_over = False
        while not is_over:
            longest_s = 1e6 if self._is_flushed else self._flush_due_s - time.monotonic()
            messages, tasks, is_over = self._queue.take_all(max(0.0, longest_s))
            if (messages or tasks) and self._is_flushed:
                self._is_flushed = False
                self._flush_due_s = time.monotonic() + self._flush_s
            self._write(messages)
            for task in tasks:
                task()
            if not self._is_flushed and time.monotonic() >= self._flush_due_s:
                self._writer.flush()
                self._is_flushed = True

    def _write(self, messages: list[BagMessage]) -> None:
        size = 0
        for message in messages:
            latched_depth = self._latched.get(message.topic)
            if latched_depth is None:
                # Held messages keep their space in the queue, so that they are limited as well.
                self._held.setdefault(message.topic, []).append(message)
                continue
            if self._snapshot is None:
                self._writer.write(message)
            else:
                self._snapshot.put(message, latched_depth)
            size += len(message.data)
            if size > _STEP_BYTES:
                self._queue.release(size)
                size = 0
        self._queue.release(size)

    def _add_topic(self, topic: BagTopic) -> None:
        if topic.name in self._latched:
            return
        self._writer.add_topic(topic)
        depths = [profile.depth or 1 for profile in topic.qos] if topic.is_latched else []
        self._latched[topic.name] = max(depths, default=0)
        self._write(self._held.pop(topic.name, []))

    def _write_snapshot(self, writer: BagWriter) -> bool:
        if self._snapshot is None:
            return False
        for message in self._snapshot.take():
            writer.write(message)
        writer.split()
        return True

    def _sync(self) -> None:
        while not self._ended.wait(_SYNC_S):
            self._writer.file.sync()
