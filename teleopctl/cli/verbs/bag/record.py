"""``teleopctl bag record``."""

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import RefusedError, UnsupportedError, UsageError

if TYPE_CHECKING:
    from teleopctl.bag import RecorderOptions, Selection, WriterOptions
    from teleopctl.node import QoSProfile


_CACHE_BYTES = 100 * 2**20
_LEVELS = ("debug", "info", "warn", "error", "fatal")
_PRESETS = ("none", "fastwrite", "zstd_fast", "zstd_small", "resilient")


def record(
    topics_positional: Annotated[
        list[str] | None,
        Argument(help="Topics; use --topics instead.", complete="topics"),
    ] = None,
    output: Annotated[
        str | None,
        Option("-o", "--output", help="Folder of the bag; by default named after the time."),
    ] = None,
    storage: Annotated[
        str, Option("-s", "--storage", help="Storage format.", choices=("mcap", "sqlite3"))
    ] = "mcap",
    topics: Annotated[
        list[str] | None, Option("--topics", help="Topics to record.", complete="topics")
    ] = None,
    static_topics_path: Annotated[
        str | None,
        Option(
            "--static-topics-path",
            help="YAML with topics and their types, subscribed to before they are published.",
            metavar="FILE",
        ),
    ] = None,
    services: Annotated[
        list[str] | None,
        Option(
            "--services",
            help="Services to record, by the events of their introspection.",
            complete="services",
        ),
    ] = None,
    actions: Annotated[
        list[str] | None,
        Option("--actions", help="Actions to record: feedback, status and events."),
    ] = None,
    topic_types: Annotated[
        list[str] | None,
        Option("--topic-types", help="Record topics of these types.", complete="message_types"),
    ] = None,
    everything: Annotated[
        bool, Option("-a", "--all", help="Record all topics, services and actions.")
    ] = False,
    all_topics: Annotated[bool, Option("--all-topics", help="Record all topics.")] = False,
    all_services: Annotated[bool, Option("--all-services", help="Record all services.")] = False,
    all_actions: Annotated[bool, Option("--all-actions", help="Record all actions.")] = False,
    regex: Annotated[
        str, Option("-e", "--regex", help="Record names that match this regular expression.")
    ] = "",
    exclude_regex: Annotated[
        str, Option("--exclude-regex", help="Exclude names that match this regular expression.")
    ] = "",
    exclude_topics: Annotated[
        list[str] | None,
        Option("--exclude-topics", help="Topics to leave out.", complete="topics"),
    ] = None,
    exclude_topic_types: Annotated[
        list[str] | None,
        Option(
            "--exclude-topic-types",
            help="Leave out topics of these types.",
            complete="message_types",
        ),
    ] = None,
    exclude_services: Annotated[
        list[str] | None,
        Option("--exclude-services", help="Services to leave out.", complete="services"),
    ] = None,
    exclude_actions: Annotated[
        list[str] | None, Option("--exclude-actions", help="Actions to leave out.")
    ] = None,
    include_unpublished_topics: Annotated[
        bool,
        Option("--include-unpublished-topics", help="Include topics without a publisher."),
    ] = False,
    include_hidden_topics: Annotated[
        bool,
        Option("--include-hidden-topics", help="Include names with a part that starts with _."),
    ] = False,
    ignore_leaf_topics: Annotated[
        bool, Option("--ignore-leaf-topics", help="Leave out topics without subscriptions.")
    ] = False,
    no_discovery: Annotated[
        bool, Option("--no-discovery", help="Record only topics that exist at the start.")
    ] = False,
    polling_interval: Annotated[  # noqa: ARG001 - graph changes are reported without polling
        int,
        Option("-p", "--polling-interval", help="Accepted and without effect.", metavar="MS"),
    ] = 100,
    qos_profile_overrides_path: Annotated[
        str | None,
        Option(
            "--qos-profile-overrides-path",
            help="YAML with QoS overrides of topics.",
            metavar="FILE",
        ),
    ] = None,
    serialization_format: Annotated[  # noqa: ARG001 - cdr is the only format
        str, Option("-f", "--serialization-format", help="Of the messages.", choices=("cdr",))
    ] = "cdr",
    max_bag_size: Annotated[
        int,
        Option("-b", "--max-bag-size", help="Start a new file after this size.", metavar="BYTES"),
    ] = 0,
    max_bag_duration: Annotated[
        int,
        Option("-d", "--max-bag-duration", help="Start a new file after this time.", metavar="S"),
    ] = 0,
    max_bag_files: Annotated[
        int,
        Option("--max-bag-files", help="Keep the newest N files; 0 for all.", metavar="N"),
    ] = 0,
    max_cache_size: Annotated[
        int,
        Option("--max-cache-size", help="Size of the write cache.", metavar="BYTES"),
    ] = _CACHE_BYTES,
    max_cache_duration: Annotated[
        int,
        Option(
            "--max-cache-duration",
            help="Duration of a snapshot; 0 for as long as fits the cache.",
            metavar="S",
        ),
    ] = 0,
    snapshot_mode: Annotated[
        bool,
        Option(
            "--snapshot-mode",
            help="Keep the newest messages in memory until ~/snapshot is called or S is pressed.",
        ),
    ] = False,
    repeat_transient_local: Annotated[
        list[str] | None,
        Option(
            "--repeat-transient-local",
            help="Accepted for compatibility with ROS 2: each file begins with the messages "
            "of latched topics.",
            metavar="TOPIC",
        ),
    ] = None,
    repeat_all_transient_local: Annotated[
        str | None,
        Option(
            "--repeat-all-transient-local",
            help="Likewise.",
            metavar="[DEPTH]",
            alone="1",
        ),
    ] = None,
    start_paused: Annotated[bool, Option("--start-paused", help="Start paused.")] = False,
    use_sim_time: Annotated[bool, Option("--use-sim-time", help="Use the time of /clock.")] = False,
    node_name: Annotated[
        str, Option("--node-name", help="The recorder's name in the graph.", metavar="NAME")
    ] = "rosbag2_recorder",
    custom_data: Annotated[
        list[str] | None,
        Option("--custom-data", help="Written into metadata.yaml.", metavar="KEY=VALUE"),
    ] = None,
    storage_preset_profile: Annotated[
        str | None,
        Option(
            "--storage-preset-profile",
            help="Preset of the storage: resilient for sqlite3, the others for mcap.",
            choices=_PRESETS,
        ),
    ] = None,
    storage_config_file: Annotated[
        str | None,
        Option(
            "--storage-config-file",
            help="YAML with rosbag2's settings of MCAP or SQLite.",
            metavar="FILE",
        ),
    ] = None,
    compression_mode: Annotated[
        str,
        Option(
            "--compression-mode",
            help="file and message both compress MCAP's chunks.",
            choices=("none", "file", "message"),
        ),
    ] = "none",
    compression_format: Annotated[
        str | None,
        Option("--compression-format", help="Of --compression-mode.", choices=("zstd",)),
    ] = None,
    compression_queue_size: Annotated[  # noqa: ARG001 - as below
        int, Option("--compression-queue-size", help="Accepted and without effect.")
    ] = 1,
    compression_threads: Annotated[  # noqa: ARG001 - chunks are compressed by the thread that writes
        int, Option("--compression-threads", help="Accepted and without effect.")
    ] = 0,
    compression_threads_priority: Annotated[  # noqa: ARG001 - as above
        int, Option("--compression-threads-priority", help="Accepted and without effect.")
    ] = 0,
    stats_max_publishing_rate: Annotated[
        float,
        Option(
            "--stats_max_publishing_rate",
            help="Highest rate at which losses are published; 0 for never.",
            metavar="HZ",
        ),
    ] = 1.0,
    log_level: Annotated[str, Option("--log-level", help="Log level.", choices=_LEVELS)] = "info",
    disable_keyboard_controls: Annotated[
        bool, Option("--disable-keyboard-controls", help="Do not read keys.")
    ] = False,
) -> None:
    """Record topics, services and actions into a bag.

    The space bar pauses and resumes. Ctrl-C ends the recording, after all received messages are
    written.
    """
    del repeat_transient_local, repeat_all_transient_local
    if topics_positional:
        console.warn(
            'Positional "topics" argument deprecated. '
            'Please use optional "--topics" argument instead.'
        )
    from dataclasses import replace

    from teleopctl.bag import RecorderOptions, Selection, read_static_topics
    from teleopctl.interfaces import NANOSECONDS_PER_SECOND, known_types

    selection = Selection(
        all_topics=all_topics or everything,
        all_services=all_services or everything,
        all_actions=all_actions or everything,
        topics=[*(topics_positional or ()), *(topics or ())],
        services=services or (),
        actions=actions or (),
        topic_types=topic_types or (),
        static_topics=read_static_topics(Path(static_topics_path)) if static_topics_path else {},
        regex=regex,
        exclude_regex=exclude_regex,
        exclude_topics=exclude_topics or (),
        exclude_topic_types=exclude_topic_types or (),
        exclude_services=exclude_services or (),
        exclude_actions=exclude_actions or (),
        include_hidden_topics=include_hidden_topics,
        include_unpublished_topics=include_unpublished_topics,
        ignore_leaf_topics=ignore_leaf_topics,
    )
    _check_selection(selection)
    if use_sim_time and no_discovery:
        raise RefusedError(
            "--use-sim-time and --no-discovery both set, but are incompatible settings. "
            "The /clock topic needs to be discovered to record with sim time."
        )
    if compression_format and compression_mode == "none":
        raise RefusedError(
            "Invalid choice: Cannot specify compression format without a compression mode."
        )
    if max_bag_files and not (max_bag_size or max_bag_duration):
        raise RefusedError("--max-bag-files requires --max-bag-size or --max-bag-duration")
    files = _writer_options(
        storage,
        storage_preset_profile,
        storage_config_file,
        compressed=compression_mode != "none",
    )
    options = RecorderOptions(
        selection=selection,
        writer=replace(
            files,
            split_bytes=max_bag_size,
            split_duration_ns=max_bag_duration * NANOSECONDS_PER_SECOND,
            most_files=max_bag_files,
            distribution=known_types().distribution,
            custom_data=_pairs(custom_data or ()),
        ),
        cache_bytes=max_cache_size,
        cache_duration_s=max_cache_duration,
        snapshot=snapshot_mode,
        start_paused=start_paused,
        use_sim_time=use_sim_time,
        discovery=not no_discovery,
        recording_metadata=storage == "mcap",
        qos=_qos_overrides(qos_profile_overrides_path),
        statistics_hz=stats_max_publishing_rate,
        node_name=node_name,
    )
    _run_recorder(
        Path(output) if output else None,
        options,
        level=log_level,
        reads_keys=not disable_keyboard_controls,
        static_topics_path=static_topics_path,
    )


def _pairs(texts: Sequence[str]) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals):
            raise UsageError(f"--custom-data is KEY=VALUE, got {text!r}")
        pairs[key] = value
    return pairs


_SNAPSHOT_KEYS = ("s", "S")


def _check_selection(selection: "Selection") -> None:
    """Reject selections that rosbag2 rejects, and warn of options without effect.

    Raises:
        RefusedError: Nothing is selected, or an exclusion has no matching selection.
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


def _writer_options(
    storage: str, preset: str | None, config_file: str | None, *, compressed: bool
) -> "WriterOptions":
    """Return the writer options for rosbag2's storage options.

    Raises:
        TeleopctlError: The preset is unknown, or the file has an unsupported setting.
    """
    from teleopctl.bag import Compression, WriterOptions, chunk_settings, database_settings

    config = Path(config_file) if config_file else None
    if storage == "sqlite3":
        if compressed:
            raise UnsupportedError(
                "Databases are written as they are, and not compressed",
                hint="Record as mcap, which is compressed by itself.",
            )
        console.note("SQLite bags cannot store robot descriptions and parameters; mcap has.")
        return WriterOptions(database_settings=database_settings(preset or "", config))
    settings = chunk_settings(preset or "", config)
    if compressed:
        console.note("MCAP has its compression in chunks: they are compressed with zstd.")
        settings = settings._replace(compression=Compression.ZSTD)
    return WriterOptions(**settings._asdict())


def _qos_overrides(file: str | None) -> "Mapping[str, QoSProfile]":
    """Return the QoS profiles of ``--qos-profile-overrides-path``.

    Raises:
        InvalidFileError: The file is not a valid file of QoS overrides.
    """
    if file is None:
        return {}
    from teleopctl.bag import read_qos_overrides

    return read_qos_overrides(Path(file))


def _run_recorder(
    folder: Path | None,
    options: "RecorderOptions",
    *,
    level: str,
    reads_keys: bool,
    static_topics_path: str | None = None,
) -> None:
    """Record until Ctrl-C, SIGTERM or SIGHUP, and finish the bag.

    Args:
        folder: Folder of the bag; None for rosbag2's default name.
        options: Options of the recorder.
        level: Lowest log level that is shown.
        reads_keys: Whether keys control the recorder.
        static_topics_path: File of the selection's static topics, for the log.

    Raises:
        RefusedError: The folder exists already.
        SystemFailureError: The bag cannot be written; the part written before can be read.
    """
    import threading

    from teleopctl.bag import Recorder, default_bag_folder
    from teleopctl.base.kept_memory import keep_freed_memory
    from teleopctl.base.keyboard import SPACE, Keyboard, keys_can_be_read
    from teleopctl.node import get_logger, set_logger_level, severity_from_name

    folder = folder or default_bag_folder()
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
        # A key pressed during the start waits until the recorder exists.
        is_made.wait()
        if recorder is not None and key == SPACE:
            recorder.toggle_paused()
        elif recorder is not None and options.snapshot and key in _SNAPSHOT_KEYS:
            recorder.take_snapshot()

    with contextlib.ExitStack() as stack:
        end = stack.enter_context(_end_on_signals())
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
            recorder.on_end(end.set)
            end.wait()
        finally:
            recorder.close()


class _EndSignal:
    """Event that a signal or another thread sets, without interrupting the main thread's work."""

    def __init__(self) -> None:
        import socket

        self._here, self.there = socket.socketpair()
        # The signal handler writes to this socket, and must not block.
        self.there.setblocking(False)

    def wait(self) -> None:
        """Block until SIGINT, SIGTERM, SIGHUP or a call of `set`."""
        import select

        select.select([self._here], [], [])

    def set(self) -> None:
        """Wake the thread that blocks in `wait`; may be called from any thread."""
        with contextlib.suppress(OSError):
            self.there.send(b"\0")

    def close(self) -> None:
        """Close both ends of the socket pair that signals write to."""
        self._here.close()
        self.there.close()


@contextlib.contextmanager
def _end_on_signals() -> Iterator[_EndSignal]:
    """Yield an `_EndSignal` that SIGINT, SIGTERM and SIGHUP set instead of ending the process."""
    import signal

    end = _EndSignal()
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
