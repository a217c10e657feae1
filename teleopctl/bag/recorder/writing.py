"""The one thread that writes what a recorder receives."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, TypeVar

from teleopctl.bag.recorder.message_queue import MessageQueue
from teleopctl.bag.recorder.snapshot import SnapshotBuffer
from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.bag.storage.bag_writer import BagWriter
from teleopctl.errors import TeleopctlError

# What is written at the latest when the process is killed is what came so long before.
_FLUSH_S = 0.5

# What is written at the latest when the machine loses its power.
_SYNC_S = 3.0

# Room is given back to those who bring messages in steps of so many bytes.
_STEP_BYTES = 2**20

# Of those who ask, at most so many wait at a time.
_MOST_ANSWERS = 1000

ResultT = TypeVar("ResultT")


class WritingThread:
    """Writes the messages of a queue to a bag, on a thread of its own.

    Messages of a topic whose definition is still being asked for are held until `add_topic`.

    Args:
        writer: The bag; this thread's alone from now on.
        queue: Where the messages come from.
        snapshot: Where they go in place of the bag, until a snapshot is taken.
        on_failure: Called once when the disk refuses; nothing is written after that.
        is_eager: Hand everything over to the operating system at once.
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
        """Add a topic, from any thread, and write its held messages."""
        self._queue.call(lambda: self._add_topic(topic))

    def ask(self, question: Callable[[BagWriter], ResultT]) -> Future[ResultT]:
        """Call a function with the writer on the writing thread; return a future of its result.

        Where the recording ends before, the answer is cancelled.
        """
        answer: Future[ResultT] = Future()

        def call() -> None:
            try:
                answer.set_result(question(self._writer))
            except TeleopctlError as error:
                answer.set_exception(error)
                raise

        self._answers.append(answer)
        if not self._queue.call(call):
            answer.cancel()
        return answer

    def split(self) -> Future[tuple[Path, Path]]:
        """Start a new file."""
        return self.ask(lambda writer: writer.split())

    def take_snapshot(self) -> Future[bool]:
        """Write the snapshot buffer to a file of its own; the result is False without one."""
        return self.ask(self._write_snapshot)

    def close(self) -> None:
        """Write all queued messages, finish the bag and end the threads.

        Raises:
            SystemFailureError: The disk refused, now or before.
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
                self._held.setdefault(message.topic, []).append(message)
            elif self._snapshot is None:
                self._writer.write(message)
            else:
                self._snapshot.put(message, latched_depth)
            size += len(message.data)
            if size > _STEP_BYTES:
                self._queue.written(size)
                size = 0
        self._queue.written(size)

    def _add_topic(self, topic: BagTopic) -> None:
        if topic.name in self._latched:
            return
        self._writer.add_topic(topic)
        depths = [profile.depth or 1 for profile in topic.qos] if topic.is_latched else []
        self._latched[topic.name] = max(depths, default=0)
        held = self._held.pop(topic.name, [])
        for message in held:
            if self._snapshot is None:
                self._writer.write(message)
            else:
                self._snapshot.put(message, self._latched[topic.name])

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
