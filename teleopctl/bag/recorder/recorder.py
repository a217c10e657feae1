"""Recorder node: writes topics into a bag, controlled by rosbag2's services."""

from __future__ import annotations

import itertools
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Self

from teleopctl.bag.recorder.losses import Losses, format_counts
from teleopctl.bag.recorder.options import RecorderOptions
from teleopctl.bag.recorder.services import RecorderServices
from teleopctl.bag.recorder.session import RecordingSession
from teleopctl.bag.recorder.subscriptions import PauseGate
from teleopctl.errors import RefusedError, TeleopctlError
from teleopctl.node import (
    Context,
    Node,
    Parameter,
    SignalHandlerOptions,
    SingleThreadedExecutor,
    spin_in_thread,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Future

# Losses are reported once a second at most: with a slow disk, thousands of messages are lost.
_REPORT_S = 1.0


def default_bag_folder() -> Path:
    """Return an unused folder path with rosbag2's default name: ``rosbag2_`` and local time.

    If the folder of this second exists, the name gets a number as suffix.
    """
    name = time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S")
    free = (Path(f"{name}_{number}") for number in itertools.count(2))
    return next(folder for folder in itertools.chain([Path(name)], free) if not folder.exists())


class Recorder:
    """Recorder of topics into a bag, from its creation until it is closed.

    The recorder has its own context, node and threads, so that a program or a test can use it with
    or without nodes:

        with Recorder(Path("session"), RecorderOptions(Selection(topics=["/joint_states"]))):
            move_the_arm()

    Args:
        folder: Folder of the bag, which must not exist; None for rosbag2's default name in the
            working directory.
        options: Options of the recording; None for every topic that is not hidden.
        context: Context of the node; None for a new one.

    Raises:
        RefusedError: The folder already exists.
        SystemFailureError: The bag cannot be created.
        TeleopctlError: No router can be reached or started.

    Attributes:
        folder: Folder of the bag.
        node: Node of the recorder.
    """

    def __init__(
        self,
        folder: Path | None = None,
        options: RecorderOptions | None = None,
        *,
        context: Context | None = None,
    ) -> None:
        self.folder = folder or default_bag_folder()
        self._options = options or RecorderOptions()
        self._gate = PauseGate(is_open=not self._options.start_paused)
        self._lock = threading.RLock()
        self._session: RecordingSession | None = None
        self._last_session: RecordingSession | None = None
        self._ended = threading.Event()
        self._on_end: Callable[[], object] | None = None
        self._is_awaited = False
        self._own_context = None if context is not None else Context()
        self._closing = threading.Event()
        if self._own_context is not None:
            self._own_context.init([], signal_handler_options=SignalHandlerOptions.NO)
        self._context = context or self._own_context
        try:
            self.node = Node(
                self._options.node_name,
                context=self._context,
                parameter_overrides=[Parameter("use_sim_time", value=self._options.use_sim_time)],
            )
            self._executor = SingleThreadedExecutor(context=self._context)
            self._services = RecorderServices(
                self.node, self, takes_snapshots=self._options.snapshot
            )
            self._executor.add_node(self.node)
            self._reporting = threading.Thread(target=self._report_losses, daemon=True)
            self.record()
        except BaseException:
            if self._own_context is not None:
                self._own_context.try_shutdown()
            raise
        self._spinning = spin_in_thread(self._executor)
        self._reporting.start()

    @property
    def options(self) -> RecorderOptions:
        """Options that were given to the recorder."""
        return self._options

    @property
    def is_recording(self) -> bool:
        """Whether a bag is open, paused or not."""
        return self._session is not None

    @property
    def is_paused(self) -> bool:
        """Whether the recording is paused."""
        return not self._gate.is_open

    @property
    def is_discovering(self) -> bool:
        """Whether topics that appear in the graph later are recorded."""
        return self._session is not None and self._session.is_discovering

    @property
    def topics(self) -> list[str]:
        """Names of the subscribed topics, sorted."""
        return [] if self._session is None else self._session.topics.names

    @property
    def message_count(self) -> int:
        """Number of received messages that were queued for the current or last bag."""
        session = self._session or self._last_session
        return 0 if session is None else session.message_count

    @property
    def skipped_count(self) -> int:
        """Number of messages received while paused, since the recorder was created."""
        return self._gate.skipped

    @property
    def losses(self) -> Losses:
        """Counts of messages lost in the current or last recording, by topic."""
        session = self._session or self._last_session
        return Losses({}, {}) if session is None else session.losses.total()

    def record(self, folder: Path | None = None) -> None:
        """Start recording into a new bag, after `stop`; raise if recording or the folder exists.

        Args:
            folder: Folder of the new bag; None for the folder of the last bag.

        Raises:
            RefusedError: The recorder is already recording, or the folder exists.
            SystemFailureError: The bag cannot be created.
        """
        with self._lock:
            if self._session is not None:
                raise RefusedError("Recorder is already recording.")
            self.folder = folder or self.folder
            logger = self.node.get_logger()
            logger.info(f"Starting recording to '{self.folder}'")
            self._session = RecordingSession(
                self.node,
                self.folder,
                self._options,
                self._gate,
                self._services.publish_split,
                self._fail,
            )
            if self._options.discovery:
                logger.info("Topics discovery started.")
                logger.info("Listening for topics...")
            if self._gate.is_open:
                logger.info("Recording...")

    def stop(self) -> None:
        """Stop recording, finish the bag, and log lost messages; nothing if not recording.

        Raises:
            SystemFailureError: Writing failed, now or before.
        """
        with self._lock:
            session = self._session
            if session is None:
                return
            self.set_discovery(active=False)
            try:
                session.close()
            finally:
                self._session, self._last_session = None, session
                logger = self.node.get_logger()
                logger.info("Recording stopped")
                losses = session.losses.total()
                if losses.in_transport:
                    logger.warning(
                        "Number of messages lost on the transport layer: "
                        f"{sum(losses.in_transport.values())}"
                        f" ({format_counts(losses.in_transport)})"
                    )
                if losses.in_recorder:
                    logger.warning(
                        "Number of messages that came faster than they could be written: "
                        f"{sum(losses.in_recorder.values())} ({format_counts(losses.in_recorder)})"
                    )

    def pause(self) -> None:
        """Pause the recording: messages received from now on are skipped."""
        if self._gate.is_open:
            self._gate.is_open = False
            self.node.get_logger().info("Pausing recording.")

    def resume(self) -> None:
        """Resume the recording; also record what latched topics received while paused."""
        if not self._gate.is_open:
            self._gate.is_open = True
            if self._session is not None:
                self._session.topics.record_kept_messages()
            self.node.get_logger().info("Resuming recording.")

    def toggle_paused(self) -> None:
        """Pause the recording, or resume it if it is paused."""
        if self._gate.is_open:
            self.pause()
        else:
            self.resume()

    def set_discovery(self, *, active: bool) -> None:
        """Start or stop recording topics that appear in the graph later."""
        session = self._session
        if session is not None and session.is_discovering != active:
            self.node.get_logger().info(f"Topics discovery {'started' if active else 'stopped'}.")
            session.set_discovery(active=active)

    def flush(self) -> None:
        """Wait until all received messages are written to the bag or the snapshot buffer.

        Those of a topic whose type definition is still requested are written once it is known.

        Raises:
            SystemFailureError: Writing failed.
        """
        if self._session is not None:
            self._session.flush()

    def split(self) -> Future[tuple[Path, Path]] | None:
        """Start a new file of the bag; return a future of both paths, or None if no bag is open."""
        return None if self._session is None else self._session.split()

    def take_snapshot(self) -> Future[bool] | None:
        """Write the snapshot buffer to the bag; return a bool future, or None if no bag is open."""
        return None if self._session is None else self._session.take_snapshot()

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until the recorder is closed or has failed; return False after the timeout."""
        self._is_awaited = True
        return self._ended.wait(timeout_s)

    def on_end(self, callback: Callable[[], object]) -> None:
        """Set a function to call when recording fails; call it at once if already ended."""
        self._on_end = callback
        self._is_awaited = True
        if self._ended.is_set():
            callback()

    def close(self) -> None:
        """Finish the bag, unsubscribe, and destroy the recorder's node; idempotent.

        Raises:
            SystemFailureError: Writing failed, now or before; the written messages are readable.
        """
        if self._closing.is_set():
            return
        self._closing.set()
        try:
            self.stop()
        finally:
            self._ended.set()
            self._executor.shutdown()
            self._spinning.join()
            self._reporting.join()
            self.node.destroy_node()
            if self._own_context is not None:
                self._own_context.try_shutdown()
            if self._last_session is not None:
                self._last_session.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _fail(self, error: TeleopctlError) -> None:
        # A waiting caller gets the error from `close` at once.
        if not self._is_awaited:
            self.node.get_logger().error(error.message)
        self._ended.set()
        if self._on_end is not None:
            self._on_end()

    def _report_losses(self) -> None:
        hz = self._options.statistics_hz
        while not self._closing.wait(max(_REPORT_S, 1.0 / hz if hz else 0.0)):
            session = self._session
            losses = session.losses.since_last_call() if session is not None else None
            if not losses:
                continue
            if losses.in_recorder:
                self.node.get_logger().warning(
                    "Messages came faster than they can be written and were dropped: "
                    + format_counts(losses.in_recorder)
                )
            if hz:
                self._services.publish_losses(losses)
