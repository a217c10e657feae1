"""``teleopctl bag play`` and ``burst``."""

from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli.verb import Argument, Option, OptionSet
from teleopctl.cli.verbs.bag.options import BagPath, Storage
from teleopctl.errors import UsageError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, from_seconds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from teleopctl.node import QoSProfile


class PlaybackOptions(OptionSet):
    """Options that ``bag play`` and ``bag burst`` share."""

    topics: Annotated[
        list[str] | None,
        Option("--topics", help="Only these topics.", metavar="TOPIC..."),
    ] = None
    services: Annotated[
        list[str] | None,
        Option("--services", help="Only the events of these services.", metavar="SERVICE..."),
    ] = None
    actions: Annotated[
        list[str] | None,
        Option("--actions", help="Only the topics of these actions.", metavar="ACTION..."),
    ] = None
    start_offset: Annotated[
        float, Option("--start-offset", help="Start this many seconds into the bag.", metavar="S")
    ] = 0.0
    remap: Annotated[
        list[str] | None,
        Option("-m", "--remap", help="Play topics under other names.", metavar="FROM:=TO..."),
    ] = None
    qos_overrides: Annotated[
        str | None,
        Option(
            "--qos-profile-overrides-path",
            help="YAML file with QoS overrides of topics.",
            metavar="FILE",
        ),
    ] = None
    read_ahead: Annotated[
        int,
        Option("--read-ahead-queue-size", help="Messages that are read before they are due."),
    ] = 1000
    storage: Storage = None
    storage_config_file: Annotated[
        str | None,
        Option(
            "--storage-config-file",
            help="Accepted for compatibility with ros2; without effect.",
            metavar="FILE",
        ),
    ] = None

    def check(self) -> None:
        """Raise a UsageError if a number is out of range or the storage config file is missing."""
        if self.read_ahead < 1:
            raise UsageError("read_ahead_queue_size must be at least 1")
        if self.start_offset < 0:
            raise UsageError(f"--start-offset {self.start_offset:g}: Value is less than zero.")
        config = self.storage_config_file
        if config is not None and not Path(config).is_file():
            raise UsageError(f"--storage-config-file: there is no file {config}")

    def qos_profiles(self) -> "Mapping[str, QoSProfile]":
        """Return the QoS profile overrides by topic from the given file; empty without one."""
        if self.qos_overrides is None:
            return {}
        from teleopctl.bag import read_qos_overrides

        return read_qos_overrides(Path(self.qos_overrides))


_STORAGES = ("mcap", "sqlite3")


def play(
    bag_path: Annotated[
        str | None,
        Argument(
            help="The bag: its folder, or one of its files.", metavar="[BAG]", complete="bags"
        ),
    ] = None,
    inputs: Annotated[
        list[str] | None,
        Option(
            "-i",
            "--input",
            help="A bag, and its storage if that is not evident; repeatable. "
            "All are played as one.",
            metavar="BAG [STORAGE]",
            complete="bags",
        ),
    ] = None,
    rate: Annotated[
        float, Option("-r", "--rate", help="Seconds of the bag per second.", metavar="RATE")
    ] = 1.0,
    loop: Annotated[bool, Option("-l", "--loop", help="Loop the playback.")] = False,
    delay: Annotated[
        float,
        Option("-d", "--delay", help="Seconds to wait before each start.", metavar="S"),
    ] = 0.0,
    playback_duration: Annotated[
        float,
        Option("--playback-duration", help="Seconds of the bag to play.", metavar="S"),
    ] = -1.0,
    playback_until_sec: Annotated[
        float,
        Option("--playback-until-sec", help="Play up to this time since 1970.", metavar="S"),
    ] = -1.0,
    playback_until_nsec: Annotated[
        int,
        Option("--playback-until-nsec", help="The same, in nanoseconds.", metavar="NS"),
    ] = -1,
    start_paused: Annotated[bool, Option("-p", "--start-paused", help="Begin paused.")] = False,
    regex: Annotated[
        str,
        Option(
            "-e",
            "--regex",
            help="Only topics whose full names match this regular expression.",
            metavar="RE",
        ),
    ] = "",
    exclude_regex: Annotated[
        str,
        Option(
            "-x",
            "--exclude-regex",
            help="Exclude topics whose names match this regular expression.",
            metavar="RE",
        ),
    ] = "",
    exclude_topics: Annotated[
        list[str] | None,
        Option("--exclude-topics", help="Not these topics.", metavar="TOPIC..."),
    ] = None,
    exclude_services: Annotated[
        list[str] | None,
        Option("--exclude-services", help="Not these services.", metavar="SERVICE..."),
    ] = None,
    exclude_actions: Annotated[
        list[str] | None,
        Option("--exclude-actions", help="Not these actions.", metavar="ACTION..."),
    ] = None,
    clock: Annotated[
        float | None,
        Option(
            "--clock",
            help="Publish /clock at this rate (40 Hz without a number), instead of the bag's.",
            metavar="[HZ]",
            alone="40",
        ),
    ] = None,
    clock_topics: Annotated[
        list[str] | None,
        Option(
            "--clock-topics",
            help="Publish /clock before each message of these topics.",
            metavar="TOPIC...",
        ),
    ] = None,
    clock_topics_all: Annotated[
        bool, Option("--clock-topics-all", help="Publish /clock before each message.")
    ] = False,
    wait_for_all_acked: Annotated[
        int,
        Option(
            "--wait-for-all-acked",
            help="Wait for slow subscribers, without a time limit, so that no messages are lost.",
            metavar="MS",
        ),
    ] = -1,
    disable_loan_message: Annotated[  # noqa: ARG001 (ros2's)
        bool,
        Option(
            "--disable-loan-message",
            help="Accepted for compatibility with ros2: no message is loaned.",
        ),
    ] = False,
    publish_service_requests: Annotated[
        bool,
        Option(
            "--publish-service-requests",
            help="Send recorded service requests, instead of publishing service events.",
        ),
    ] = False,
    send_actions_as_client: Annotated[
        bool,
        Option(
            "--send-actions-as-client",
            help="Send recorded action requests, instead of publishing action topics.",
        ),
    ] = False,
    service_requests_source: Annotated[
        str,
        Option(
            "--service-requests-source",
            help="Side whose events contain the requests to send.",
            choices=("service_introspection", "client_introspection"),
        ),
    ] = "service_introspection",
    message_order: Annotated[
        str,
        Option(
            "--message-order",
            help="Order and timing by the time of reception or of publication.",
            choices=("received", "sent"),
        ),
    ] = "received",
    progress_bar_update_rate: Annotated[
        int,
        Option(
            "--progress-bar-update-rate",
            help="Updates of the progress per second on a terminal; 0 for none, -1 for each "
            "message.",
            metavar="HZ",
        ),
    ] = 3,
    progress_bar_separation_lines: Annotated[
        int,
        Option(
            "--progress-bar-separation-lines",
            help="Empty lines between the progress and the other output.",
            metavar="N",
        ),
    ] = 2,
    disable_keyboard_controls: Annotated[
        bool, Option("--disable-keyboard-controls", help="Do not read the keyboard.")
    ] = False,
    log_level: Annotated[
        str,
        Option(
            "--log-level",
            help="Lowest log level to show.",
            choices=("debug", "info", "warn", "error", "fatal"),
        ),
    ] = "info",
    *,
    shared: PlaybackOptions,
) -> int:
    """Play a bag into the graph, with the original timing.

    On a terminal, the space bar pauses, the right arrow sends the next message while paused, and
    up and down change the rate. The node rosbag2_player has services for the same and more.
    """
    _check_positive("--rate", rate)
    if clock is not None:
        _check_positive("--clock", clock)
    if delay < 0:
        raise UsageError(f"--delay {delay:g} is not in the valid range (>= 0.0)")
    if wait_for_all_acked < -1 or progress_bar_separation_lines < 0:
        raise UsageError("a time to wait and a number of lines are not less than zero")
    _check_alone(
        ("--clock", clock),
        ("--clock-topics", clock_topics),
        ("--clock-topics-all", clock_topics_all),
    )
    _check_alone(
        ("--playback-until-sec", playback_until_sec >= 0),
        ("--playback-until-nsec", playback_until_nsec >= 0),
    )
    from teleopctl.bag import PlayOptions, PlaySelection
    from teleopctl.cli.verbs.bag.playing import Terminal, play_bags

    until_ns = playback_until_nsec if playback_until_nsec >= 0 else None
    if playback_until_sec >= 0:
        until_ns = int(playback_until_sec * NANOSECONDS_PER_SECOND)
    options = PlayOptions(
        rate=rate,
        loop=loop,
        delay_s=delay,
        start_offset_ns=from_seconds(shared.start_offset),
        duration_ns=from_seconds(playback_duration) if playback_duration >= 0 else None,
        until_ns=until_ns,
        is_paused=start_paused,
        selection=PlaySelection(
            topics=tuple(shared.topics or ()),
            services=tuple(shared.services or ()),
            actions=tuple(shared.actions or ()),
            exclude_topics=tuple(exclude_topics or ()),
            exclude_services=tuple(exclude_services or ()),
            exclude_actions=tuple(exclude_actions or ()),
            regex=regex,
            exclude_regex=exclude_regex,
        ),
        qos_overrides=shared.qos_profiles(),
        clock_hz=clock,
        clock_topics=None if clock_topics_all else tuple(clock_topics or ()),
        is_lossless=wait_for_all_acked >= 0,
        read_ahead=shared.read_ahead,
        message_order="sent" if message_order == "sent" else "received",
        publishes_requests=publish_service_requests,
        sends_actions=send_actions_as_client,
        request_source=(
            "client_introspection"
            if service_requests_source == "client_introspection"
            else "service_introspection"
        ),
    )
    terminal = Terminal(
        not disable_keyboard_controls,
        progress_bar_update_rate,
        progress_bar_separation_lines,
        log_level,
    )
    return play_bags(
        parse_bag_paths(bag_path, shared.storage, inputs or []),
        options,
        shared.remap or [],
        terminal,
    )


def parse_bag_paths(
    bag_path: str | None, storage: str | None, inputs: list[str]
) -> list[tuple[Path, str | None]]:
    """Return the paths of the bags that a command line names, each with its storage or None.

    Args:
        bag_path: Path of the positional argument, or None.
        storage: Storage format of bags without one of their own, or None.
        inputs: Values of ``--input``: paths of bags, each optionally followed by its storage
            format.

    Raises:
        UsageError: No bag is given, or the argument and the option are mixed.
    """
    if bag_path is not None:
        if inputs:
            raise UsageError(
                "do not mix the [bag_path] positional argument and the -i,--input option; "
                "for multiple input bags, use -i,--input multiple times"
            )
        return [(Path(bag_path), storage)]
    bags: list[tuple[Path, str | None]] = []
    for word in inputs:
        if word in _STORAGES and bags and bags[-1][1] is None:
            bags[-1] = (bags[-1][0], word)
        else:
            bags.append((Path(word), None))
    if not bags:
        raise UsageError("no input bags were provided")
    return [(path, named or storage) for path, named in bags]


def _check_positive(flag: str, value: float) -> None:
    if value <= 0:
        raise UsageError(f"{flag} {value:g} is not in the valid range (> 0.0)")


def _check_alone(*options: tuple[str, object]) -> None:
    given = [flag for flag, value in options if value]
    if len(given) > 1:
        raise UsageError(f"{given[0]} and {given[1]} exclude each other")


def burst(
    bag_path: BagPath,
    num_messages: Annotated[
        int,
        Option("-n", "--num-messages", help="Number of messages to send; 0 for all.", metavar="N"),
    ] = 0,
    *,
    shared: PlaybackOptions,
) -> int:
    """Send messages of a bag as fast as they can be read, then pause.

    Then the keys and services of `bag play` control the player. Ends on Ctrl-C.
    """
    if num_messages < 0:
        raise UsageError(f"--num-messages {num_messages}: Value is less than zero.")
    from teleopctl.bag import PlayOptions, PlaySelection
    from teleopctl.cli.verbs.bag.playing import Terminal, play_bags

    options = PlayOptions(
        is_paused=True,
        is_lossless=True,
        start_offset_ns=from_seconds(shared.start_offset),
        selection=PlaySelection(
            tuple(shared.topics or ()), tuple(shared.services or ()), tuple(shared.actions or ())
        ),
        qos_overrides=shared.qos_profiles(),
        read_ahead=shared.read_ahead,
    )
    bags = [(Path(bag_path), shared.storage)]
    return play_bags(bags, options, shared.remap or [], Terminal(), burst=num_messages)
