"""Recording session: one bag, from its first message to its end."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.bag.recorder.losses import LossCounter
from teleopctl.bag.recorder.options import CACHE_BYTES, RecorderOptions
from teleopctl.bag.recorder.recording_metadata import RecordingMetadata
from teleopctl.bag.recorder.subscriptions import DomainSubscription, PauseGate, RecordedTopics
from teleopctl.bag.recorder.writing import MessageQueue, SnapshotBuffer, WritingThread
from teleopctl.bag.storage.bag_writer import BagWriter
from teleopctl.node import LoggingSeverity

if TYPE_CHECKING:
    from teleopctl.errors import TeleopctlError
    from teleopctl.node import Node


class RecordingSession:
    """Recording into one bag; with simulated time, it starts with the first /clock.

    Args:
        node: Node that the subscriptions belong to.
        folder: Folder of the bag, which must not exist.
        options: Options of the recording.
        gate: Pause state of the recorder.
        on_split: Called with the paths of the closed and the new file when the bag is split.
        on_failure: Called once with the error when writing fails.

    Raises:
        RefusedError: The folder already exists.
        SystemFailureError: The bag cannot be created.

    Attributes:
        losses: Counter of lost messages.
        topics: Subscriptions to the recorded topics.
        writing: Thread that writes the bag.
    """

    def __init__(
        self,
        node: Node,
        folder: Path,
        options: RecorderOptions,
        gate: PauseGate,
        on_split: Callable[[Path, Path], object],
        on_failure: Callable[[TeleopctlError], object],
    ) -> None:
        self._node = node
        self._options = options
        self._logger = node.get_logger()
        if not options.logs_topics:
            self._logger = self._logger.get_child("topics")
            self._logger.set_level(LoggingSeverity.WARN)
        writer = BagWriter(folder, options.writer)
        writer.on_split = on_split
        self._queue = queue = MessageQueue(options.cache_bytes or CACHE_BYTES)
        snapshot = None
        if options.snapshot:
            snapshot = SnapshotBuffer(options.cache_bytes, options.cache_duration_s)
        self.losses = LossCounter()
        self.writing = WritingThread(
            writer, queue, snapshot, on_failure, is_eager=not options.cache_bytes
        )
        self._domain_subscription = DomainSubscription(node) if options.from_first_message else None
        self.topics = RecordedTopics(
            node,
            options.selection.with_absolute_names(
                lambda name: node.resolve_topic_name(name, only_expand=True),
                lambda name: node.resolve_service_name(name, only_expand=True),
            ),
            options.qos,
            queue,
            gate,
            self.losses,
            self.writing.add_topic,
            uses_simulated_time=options.use_sim_time,
            domain_subscription=self._domain_subscription,
            logger=self._logger,
        )
        self._metadata: RecordingMetadata | None = None
        self._changed = threading.Event()
        self._is_over = threading.Event()
        self._follows = options.discovery
        self._thread = threading.Thread(target=self._run, name="bag topics", daemon=True)
        if not options.use_sim_time:
            self._begin()
        node.add_graph_callback(self._changed.set)
        node.get_clock().on_time_update(self._clock_moved)
        self._changed.set()
        self._thread.start()

    @property
    def is_discovering(self) -> bool:
        """Whether topics that appear in the graph later are recorded."""
        return self._follows

    @property
    def message_count(self) -> int:
        """Number of received messages that were queued for the bag, without dropped ones."""
        return self._queue.count

    def set_discovery(self, *, active: bool) -> None:
        """Start or stop recording topics that appear in the graph later."""
        self._follows = active
        self._changed.set()

    def flush(self) -> None:
        """Wait until all received messages are written to the bag or the snapshot buffer.

        Those of a topic whose type definition is still requested are written once it is known.

        Raises:
            SystemFailureError: Writing failed.
        """
        with contextlib.suppress(CancelledError):
            self.writing.call(lambda writer: writer.flush()).result()

    def split(self) -> Future[tuple[Path, Path]]:
        """Start a new file of the bag; return a future of the closed and the new file's path."""
        return self.writing.split()

    def take_snapshot(self) -> Future[bool]:
        """Write the snapshot buffer to the bag; return a future of the success."""
        return self.writing.take_snapshot()

    def close(self) -> None:
        """Unsubscribe, write all received messages, and finish the bag.

        Raises:
            SystemFailureError: Writing failed, now or before.
        """
        self._is_over.set()
        self._changed.set()
        self._node.get_clock().forget_on_time_update(self._clock_moved)
        self._thread.join()
        if self._metadata is not None:
            self._metadata.close()
        self.topics.close()
        if self._domain_subscription is not None:
            self._domain_subscription.close()
        self.writing.close()

    def join(self) -> None:
        """Wait for the end of pending parameter requests to other nodes, after `close`."""
        if self._metadata is not None:
            self._metadata.join()

    def _begin(self) -> None:
        self.topics.update(self._node.graph())
        if self._options.recording_metadata:
            self._metadata = RecordingMetadata(
                self._node,
                lambda attachment: self.writing.call(lambda writer: writer.attach(attachment)),
                lambda name, values: self.writing.call(
                    lambda writer: writer.add_record(name, values)
                ),
                self._node.get_clock().nanoseconds,
            )

    def _run(self) -> None:
        logger = self._logger
        if self._options.use_sim_time:
            logger.info("use_sim_time set, waiting for /clock before starting recording...")
            while not self._is_over.is_set() and not self._node.get_clock().nanoseconds():
                self._changed.wait()
                self._changed.clear()
            if self._is_over.is_set():
                return
            logger.info("Sim time /clock found, starting recording.")
            self._begin()
            self._changed.set()
        while not self._is_over.is_set():
            self._changed.wait()
            self._changed.clear()
            if self._follows and not self._is_over.is_set():
                self.topics.update(self._node.graph())
            # One definition at a time, so that new topics do not wait for all definitions.
            if not self._is_over.is_set() and self.topics.request_definition(self._node.graph()):
                self._changed.set()

    def _clock_moved(self) -> None:
        # Ends the wait for the first message of /clock.
        if self._options.use_sim_time and not self._changed.is_set():
            self._changed.set()
