"""Runs a recorder until it is told to end, and checks what was asked of it."""

from __future__ import annotations

import contextlib
import select
import signal
import socket
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console
from teleopctl.cli.verbs.bag.keyboard import SPACE, Keyboard, keys_can_be_read
from teleopctl.errors import RefusedError, UnsupportedError

if TYPE_CHECKING:
    from teleopctl.bag import Recorder, RecorderOptions, Selection, WriterOptions
    from teleopctl.node import QoSProfile

_SNAPSHOT_KEYS = ("s", "S")


def check_selection(selection: Selection) -> None:
    """Refuse selections that rosbag2 refuses, and warn of options without effect.

    Raises:
        RefusedError: Nothing is selected, or something is excluded from nothing.
    """
    if selection.is_empty:
        raise RefusedError(
            "Need to specify at least one option out of --all, --all-topics, --all-services, "
            "--all-actions, --services, --actions, --topics, --topic-types, --static-topics-path "
            "or --regex"
        )
    s = selection
    by_topic = s.all_topics or s.topic_types or s.regex
    anything = by_topic or s.all_services or s.all_actions
    for excluded, has_base, flag, bases in (
        (
            s.exclude_regex,
            anything,
            "--exclude-regex",
            "--all, --all-topics, --topic-types, --all-services, --all-actions or --regex",
        ),
        (
            s.exclude_topics,
            by_topic,
            "--exclude-topics",
            "--all, --all-topics, --topic-types or --regex",
        ),
        (
            s.exclude_topic_types,
            by_topic,
            "--exclude-topic-types",
            "--all, --all-topics or --regex",
        ),
        (
            s.exclude_services,
            s.all_services or s.regex,
            "--exclude-services",
            "--all, --all-services or --regex",
        ),
        (
            s.exclude_actions,
            s.all_actions or s.regex,
            "--exclude-actions",
            "--all, --all-actions or --regex",
        ),
    ):
        if excluded and not has_base:
            raise RefusedError(f"{flag} argument requires either {bases}")
    for everything, named, flags, flag in (
        (s.all_services, s.services, "--all or --all-services", "--services"),
        (s.all_topics, s.topics, "--all or --all-topics", "--topics"),
        (s.all_actions, s.actions, "--all or --all-actions", "--actions"),
    ):
        if everything and named:
            console.warn(f"{flags} will override {flag}")
    if s.regex and (s.all_topics or s.all_services or s.all_actions):
        console.warn("--all, --all-topics, --all-services or --all-actions will override --regex")


def files(
    storage: str, preset: str | None, config_file: str | None, *, compressed: bool
) -> WriterOptions:
    """Return the writer options for rosbag2's storage options.

    Raises:
        TeleopctlError: There is no such preset, or the file asks for what there is not.
    """
    from teleopctl.bag import Compression, WriterOptions, chunk_settings, database_settings

    config = Path(config_file) if config_file else None
    if storage == "sqlite3":
        if compressed:
            raise UnsupportedError(
                "Databases are written as they are, and not compressed",
                hint="Record as mcap, which is compressed by itself.",
            )
        console.note("A database has no place for robot descriptions and parameters; mcap has.")
        return WriterOptions(database_settings=database_settings(preset or "", config))
    settings = chunk_settings(preset or "", config)
    if compressed:
        console.note("MCAP has its compression in chunks: they are compressed with zstd.")
        settings = settings._replace(compression=Compression.ZSTD)
    return WriterOptions(**settings._asdict())


def overrides(file: str | None) -> Mapping[str, QoSProfile]:
    """Return the QoS profiles of ``--qos-profile-overrides-path``.

    Raises:
        InvalidFileError: The file is none of that kind.
    """
    if file is None:
        return {}
    from teleopctl.bag import read_qos_overrides

    return read_qos_overrides(Path(file))


def run(
    folder: Path | None,
    options: RecorderOptions,
    *,
    level: str,
    reads_keys: bool,
    static_topics_path: str | None = None,
) -> None:
    """Record until Ctrl-C, SIGTERM or the terminal's end, and finish the bag.

    Args:
        folder: Where the bag is to be; None for rosbag2's name.
        options: What is recorded, and how.
        level: What the log tells.
        reads_keys: Whether the space bar pauses.
        static_topics_path: Where the selection has its static topics from, for the log.

    Raises:
        RefusedError: There is something at the place of the bag already.
        SystemFailureError: The disk refused; what was written can be read.
    """
    from teleopctl.bag import Recorder, default_folder
    from teleopctl.base.kept_memory import keep_freed_memory
    from teleopctl.node import get_logger, set_logger_level, severity_from_name

    folder = folder or default_folder()
    if folder.exists():
        raise RefusedError(
            f"Output folder '{folder}' already exists.", hint="Name another one, or remove it."
        )
    keep_freed_memory()
    set_logger_level("", severity_from_name(level))
    logger = get_logger(options.node_name)
    recorder: Recorder | None = None
    is_made = threading.Event()

    def press(key: str) -> None:
        # Pressed while it starts, which the log has said already.
        is_made.wait()
        if recorder is not None and key == SPACE:
            recorder.toggle_paused()
        elif recorder is not None and options.snapshot and key in _SNAPSHOT_KEYS:
            recorder.take_snapshot()

    with contextlib.ExitStack() as stack:
        end = stack.enter_context(_told_to_end())
        if reads_keys and keys_can_be_read():
            stack.enter_context(Keyboard(press))
            logger.info("Press SPACE for pausing/resuming")
            if options.snapshot:
                logger.info("Press S for writing a snapshot")
        if static_topics_path is not None:
            logger.info(f"Reading static topics from {static_topics_path}")
            logger.info(f"Read {len(options.selection.static_topics)} static topics")
        try:
            recorder = Recorder(folder, options)
        finally:
            is_made.set()
        try:
            if reads_keys and keys_can_be_read() and options.start_paused:
                logger.info("Wait for recording: Press SPACE to start.")
            recorder.on_end(end.tell)
            end.wait()
        finally:
            recorder.close()


class _End:
    """Wakes the main thread: by a signal, which must not interrupt what it does, or by another."""

    def __init__(self) -> None:
        self._here, self.there = socket.socketpair()
        # The system's handler writes to it, and must not wait.
        self.there.setblocking(False)

    def wait(self) -> None:
        """Wait for a signal or for `tell`."""
        select.select([self._here], [], [])

    def tell(self) -> None:
        """Wake the waiting thread."""
        with contextlib.suppress(OSError):
            self.there.send(b"\0")

    def close(self) -> None:
        """Close both ends of the socket."""
        self._here.close()
        self.there.close()


@contextlib.contextmanager
def _told_to_end() -> Iterator[_End]:
    """Have the signals that end a command end a wait instead, also while the bag is finished."""
    end = _End()
    numbers: Sequence[int] = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP"):
        numbers = [*numbers, signal.SIGHUP]
    before = {number: signal.signal(number, lambda *_: None) for number in numbers}
    woken_before = signal.set_wakeup_fd(end.there.fileno(), warn_on_full_buffer=False)
    try:
        yield end
    finally:
        signal.set_wakeup_fd(woken_before)
        for number, handler in before.items():
            signal.signal(number, handler)
        end.close()
