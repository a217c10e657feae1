"""``rosbag2_py._transport``. Recorder, player and conversion of bags."""

import contextlib
import dataclasses
import datetime
import enum
import re
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from rosbag2_py._storage import StorageOptions, errors_of_rosbag2
from rosbag2_py._writer import writer_options
from teleopctl import bag
from teleopctl.node import set_logger_level, severity_from_name

__all__ = [
    "PlayOptions",
    "Player",
    "RecordOptions",
    "Recorder",
    "ServiceRequestsSource",
    "bag_rewrite",
]


class ServiceRequestsSource(enum.IntEnum):
    """Side whose introspection events are used to send requests."""

    SERVICE_INTROSPECTION = 0
    CLIENT_INTROSPECTION = 1


@dataclass
class PlayOptions:
    """Options of a player, as those of ``ros2 bag play``; durations in seconds."""

    read_ahead_queue_size: int = 1000
    node_prefix: str = ""
    rate: float = 1.0
    topics_to_filter: list[str] = field(default_factory=list)
    services_to_filter: list[str] = field(default_factory=list)
    regex_to_filter: str = ""
    exclude_regex_to_filter: str = ""
    exclude_topics_to_filter: list[str] = field(default_factory=list)
    exclude_service_events_to_filter: list[str] = field(default_factory=list)
    topic_qos_profile_overrides: Mapping[str, QoSProfile] = field(default_factory=dict)
    loop: bool = False
    topic_remapping_options: list[str] = field(default_factory=list)
    clock_publish_frequency: float = 0.0
    clock_publish_on_topic_publish: bool = False
    clock_topics: list[str] = field(default_factory=list)
    delay: float = 0.0
    playback_duration: float = -1.0
    playback_until_timestamp: int = -1
    start_paused: bool = False
    start_offset: float = 0.0
    disable_keyboard_controls: bool = False
    wait_acked_timeout: int = -1
    disable_loan_message: bool = False
    publish_service_requests: bool = False
    service_requests_source: ServiceRequestsSource = ServiceRequestsSource.SERVICE_INTROSPECTION


@dataclass
class RecordOptions:
    """Options of a recorder, as those of ``ros2 bag record``."""

    all_topics: bool = False
    all_services: bool = False
    is_discovery_disabled: bool = False
    topics: list[str] = field(default_factory=list)
    topic_types: list[str] = field(default_factory=list)
    services: list[str] = field(default_factory=list)
    exclude_topics: list[str] = field(default_factory=list)
    exclude_topic_types: list[str] = field(default_factory=list)
    exclude_service_events: list[str] = field(default_factory=list)
    rmw_serialization_format: str = ""
    topic_polling_interval: datetime.timedelta = datetime.timedelta(milliseconds=100)
    regex: str = ""
    exclude_regex: str = ""
    node_prefix: str = ""
    compression_mode: str = ""
    compression_format: str = ""
    compression_queue_size: int = 1
    compression_threads: int = 0
    compression_threads_priority: int = 0
    topic_qos_profile_overrides: Mapping[str, QoSProfile] = field(default_factory=dict)
    include_hidden_topics: bool = False
    include_unpublished_topics: bool = False
    ignore_leaf_topics: bool = False
    start_paused: bool = False
    use_sim_time: bool = False
    disable_keyboard_controls: bool = False


class _Cancellable:
    """Base of recorder and player: their work ends by `cancel` or by a signal.

    Args:
        log_level: Name of the level of the loggers; INFO if empty.

    Raises:
        RuntimeError: There is no level of that name.
    """

    _running: "set[threading.Event]"

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls._running = set()

    def __init__(self, log_level: str = "") -> None:
        with errors_of_rosbag2():
            if log_level:
                set_logger_level("", severity_from_name(log_level))

    @classmethod
    def cancel(cls) -> None:
        """End all that run, from another thread or a signal handler."""
        for end in tuple(cls._running):
            end.set()

    @contextlib.contextmanager
    def _context(self) -> Iterator[tuple[Context, threading.Event]]:
        """Return a context manager with a context, and the event that ends the work."""
        context, end = Context(), threading.Event()
        is_main = threading.current_thread() is threading.main_thread()
        options = SignalHandlerOptions.ALL if is_main else SignalHandlerOptions.NO
        context.init([], signal_handler_options=options)
        context.on_shutdown(end.set)
        self._running.add(end)
        try:
            with contextlib.suppress(KeyboardInterrupt):
                yield context, end
        finally:
            self._running.discard(end)
            context.try_shutdown()


class Recorder(_Cancellable):
    """Recorder of topics into a bag.

    Example:
        >>> recorder = Recorder()
        >>> options = RecordOptions()
        >>> options.all_topics = True
        >>> recorder.record(StorageOptions(uri="session"), options)  # until `cancel` or Ctrl-C
    """

    def record(
        self,
        storage_options: StorageOptions,
        record_options: RecordOptions,
        node_name: str = "rosbag2_recorder",
    ) -> None:
        """Record until `cancel`, SIGINT or SIGTERM.

        Raises:
            RuntimeError: An option is not possible, or the bag cannot be written.
        """
        chosen = record_options
        compressed = chosen.compression_mode.lower() not in ("", "none")
        writer = writer_options(storage_options, compressed=compressed)
        with errors_of_rosbag2():
            options = bag.RecorderOptions(
                selection=bag.Selection(
                    all_topics=chosen.all_topics,
                    all_services=chosen.all_services,
                    topics=chosen.topics,
                    services=_services(chosen.services),
                    topic_types=chosen.topic_types,
                    regex=chosen.regex,
                    exclude_regex=chosen.exclude_regex,
                    exclude_topics=chosen.exclude_topics,
                    exclude_topic_types=chosen.exclude_topic_types,
                    exclude_services=_services(chosen.exclude_service_events),
                    include_hidden_topics=chosen.include_hidden_topics,
                    include_unpublished_topics=chosen.include_unpublished_topics,
                    ignore_leaf_topics=chosen.ignore_leaf_topics,
                ),
                writer=writer,
                snapshot=storage_options.snapshot_mode,
                start_paused=chosen.start_paused,
                use_sim_time=chosen.use_sim_time,
                discovery=not chosen.is_discovery_disabled,
                qos=chosen.topic_qos_profile_overrides,
                node_name=chosen.node_prefix + node_name,
            )
            if storage_options.max_cache_size:
                options = dataclasses.replace(options, cache_bytes=storage_options.max_cache_size)
            with self._context() as (context, end):
                folder = Path(storage_options.uri) if storage_options.uri else None
                recorder = bag.Recorder(folder, options, context=context)
                try:
                    recorder.on_end(end.set)
                    end.wait()
                finally:
                    recorder.close()


class Player(_Cancellable):
    """Player of bags."""

    def play(self, storage_options: StorageOptions, play_options: PlayOptions) -> None:
        """Play a bag to its end, or until `cancel`, SIGINT or SIGTERM.

        Raises:
            RuntimeError: An option is not possible, or the bag cannot be read.
        """
        with self._playing(storage_options, play_options) as (player, end):
            player.play()
            while not end.is_set() and not player.wait(0.1):
                pass

    def burst(
        self, storage_options: StorageOptions, play_options: PlayOptions, num_messages: int
    ) -> None:
        """Play messages of a bag as fast as possible.

        Args:
            storage_options: Path of the bag.
            play_options: Options of the player, which starts paused.
            num_messages: Number of messages; 0 for all.

        Raises:
            RuntimeError: An option is not possible, or the bag cannot be read.
        """
        play_options.start_paused = True
        with self._playing(storage_options, play_options) as (player, _):
            player.play()
            player.burst(num_messages)
            player.stop()

    @contextlib.contextmanager
    def _playing(
        self, storage_options: StorageOptions, play_options: PlayOptions
    ) -> Iterator[tuple[bag.Player, threading.Event]]:
        with errors_of_rosbag2():
            options = _player_options(play_options)
            remaps = [word for rule in play_options.topic_remapping_options for word in _rule(rule)]
            with self._context() as (context, end):
                node = Node(
                    f"{play_options.node_prefix}rosbag2_player",
                    context=context,
                    cli_args=["--ros-args", *remaps] if remaps else None,
                )
                executor = SingleThreadedExecutor(context=context)
                executor.add_node(node)
                thread = threading.Thread(target=executor.spin, daemon=True)
                path = (Path(storage_options.uri), storage_options.storage_id or None)
                with bag.Player(node, [path], options) as player:
                    thread.start()
                    try:
                        yield player, end
                    finally:
                        player.stop()
                executor.shutdown()
                thread.join()
                node.destroy_node()


def _rule(rule: str) -> list[str]:
    return ["--remap", rule] if ":=" in rule else [rule]


def _services(names: list[str]) -> list[str]:
    """Return names of services from these or from those of their event topics."""
    return [re.sub("/_service_event$", "", name) for name in names]


def _player_options(chosen: PlayOptions) -> bag.PlayOptions:
    by_topic = chosen.clock_publish_on_topic_publish
    is_server = chosen.service_requests_source is ServiceRequestsSource.SERVICE_INTROSPECTION
    return bag.PlayOptions(
        rate=chosen.rate,
        loop=chosen.loop,
        delay_s=_seconds(chosen.delay),
        start_offset_ns=round(_seconds(chosen.start_offset) * 1e9),
        duration_ns=(
            round(_seconds(chosen.playback_duration) * 1e9)
            if _seconds(chosen.playback_duration) >= 0
            else None
        ),
        until_ns=chosen.playback_until_timestamp if chosen.playback_until_timestamp >= 0 else None,
        is_paused=chosen.start_paused,
        selection=bag.PlaySelection(
            topics=tuple(chosen.topics_to_filter),
            services=tuple(_services(chosen.services_to_filter)),
            exclude_topics=tuple(chosen.exclude_topics_to_filter),
            exclude_services=tuple(_services(chosen.exclude_service_events_to_filter)),
            regex=chosen.regex_to_filter,
            exclude_regex=chosen.exclude_regex_to_filter,
        ),
        qos_overrides=chosen.topic_qos_profile_overrides,
        clock_hz=chosen.clock_publish_frequency or None,
        clock_topics=(tuple(chosen.clock_topics) or None) if by_topic else (),
        is_lossless=chosen.wait_acked_timeout >= 0,
        read_ahead=chosen.read_ahead_queue_size,
        publishes_requests=chosen.publish_service_requests,
        request_source="service_introspection" if is_server else "client_introspection",
    )


def _seconds(duration: object) -> float:
    """Return a duration in seconds, which programs also give as a `Duration`."""
    nanoseconds = getattr(duration, "nanoseconds", None)
    return float(duration) if nanoseconds is None else nanoseconds / 1e9  # type: ignore[arg-type]


def bag_rewrite(input_options: list[StorageOptions], output_config_file: str) -> None:
    """Rewrite bags as an output options file defines; see ``ros2 bag convert``.

    Args:
        input_options: Bags to read, merged by time.
        output_config_file: YAML file with the list ``output_bags``.

    Raises:
        RuntimeError: A bag cannot be read or written, or the file is invalid.
    """
    with errors_of_rosbag2(), contextlib.ExitStack() as stack:
        outputs, _ = bag.read_output_options(Path(output_config_file))
        inputs: list[bag.Bag] = []
        for options in input_options:
            opened = stack.enter_context(bag.open_bag(options.uri, options.storage_id or None))
            end_ns = options.end_time_ns + 1 if options.end_time_ns >= 0 else bag.NO_TIME_NS
            inputs.append(bag.BagPart(opened, max(0, options.start_time_ns), end_ns))
        bag.copy_bags(inputs, outputs)
