"""``teleopctl bag`` verbs that write, check and repair bags."""

import contextlib
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.bag.options import (
    BagPath,
    BagPaths,
    ChosenServices,
    ChosenTopics,
    ChosenTypes,
    ExcludeRegex,
    ExcludeTopics,
    ExcludeTypes,
    FileOptions,
    OutputFolder,
    Regex,
    Storage,
    TimeRangeOptions,
)
from teleopctl.errors import NotFoundError, UsageError, existing_names_hint

if TYPE_CHECKING:
    from teleopctl.bag import Bag, BagTopic, InputBag, OutputBag


_STORAGES = ("mcap", "sqlite3")


def convert_bag(
    output: Annotated[
        str,
        Option(
            "-o",
            "--output-options",
            help="Output folder, or a YAML file with the outputs, as in ros2 bag.",
            metavar="FOLDER_OR_YAML",
        ),
    ],
    words: Annotated[
        list[str] | None,
        Argument(help="The bags, merged by time.", metavar="BAG...", complete="bags"),
    ] = None,
    inputs: Annotated[
        list[str] | None,
        Option(
            "-i",
            "--input",
            help="A bag, and its storage (mcap or sqlite3) if that is not evident; repeatable.",
            metavar="BAG",
            complete="bags",
        ),
    ] = None,
    input_options: Annotated[
        str | None,
        Option(
            "--input-options",
            help="YAML file with the bags, and the time range of each.",
            metavar="YAML",
        ),
    ] = None,
    storage: Annotated[
        str, Option("-s", "--storage", help="Storage format of the output.", choices=_STORAGES)
    ] = "mcap",
    as_json: AsJson = False,
    *,
    files: FileOptions,
) -> None:
    """Convert bags, for example to SQLite or compressed files, or ROS 1 bags to MCAP.

    A YAML file can describe several outputs, each with its own topics, storage format, compression
    and sizes.
    """
    from teleopctl.bag import BagPart, OutputBag, read_output_options

    sources = _input_bags(inputs or [], words or [], input_options)
    target = Path(output)
    options = files.writer_options(storage)
    outputs = [OutputBag(target, options=options)]
    if target.suffix in (".yaml", ".yml") or target.is_file():
        outputs, remarks = read_output_options(target)
        for remark in remarks:
            console.warn(remark)
    with _open_bags(
        [str(source.path) for source in sources], [source.storage for source in sources]
    ) as bags:
        parts = [
            BagPart(bag, source.start_ns, source.end_ns)
            for bag, source in zip(bags, sources, strict=True)
        ]
        _write_bags(parts, outputs, as_json=as_json)


def cut_bag(
    bag_path: BagPath,
    output: OutputFolder,
    storage: Storage = None,
    as_json: AsJson = False,
    *,
    time_range: TimeRangeOptions,
    files: FileOptions,
) -> None:
    """Write a time range of a bag to a new bag, which can be played alone.

    The new bag starts with the last messages of latched topics, such as /tf_static and
    /robot_description.
    """
    from teleopctl.bag import OutputBag

    if time_range.is_whole:
        raise UsageError("Give the range to keep: --start-offset or --from, --duration or --until")
    options = files.writer_options()
    with _open_bags([bag_path], [storage]) as bags:
        start_ns, end_ns = time_range.log_times(bags)
        cut = OutputBag(
            Path(output), start_ns=start_ns, end_ns=end_ns, continues_latched=True, options=options
        )
        _write_bags(bags, [cut], as_json=as_json)


def filter_bag(
    bag_path: BagPath,
    output: OutputFolder,
    topics: ChosenTopics = None,
    services: ChosenServices = None,
    topic_types: ChosenTypes = None,
    regex: Regex = "",
    exclude_regex: ExcludeRegex = "",
    exclude_topics: ExcludeTopics = None,
    exclude_topic_types: ExcludeTypes = None,
    storage: Storage = None,
    as_json: AsJson = False,
    *,
    time_range: TimeRangeOptions,
    files: FileOptions,
) -> None:
    """Write some topics, or a time range, of a bag to a new bag.

    Selected messages are copied unchanged, with attachments, QoS profiles and type definitions.
    Without a selection all topics are copied, except excluded ones.
    """
    from teleopctl.bag import OutputBag

    options = files.writer_options()
    chooses = _topic_filter(
        topics,
        services,
        topic_types,
        regex,
        exclude_regex,
        exclude_topics,
        exclude_topic_types,
    )
    with _open_bags([bag_path], [storage]) as bags:
        _require_topics(bags, topics or ())
        start_ns, end_ns = time_range.log_times(bags)
        _write_bags(
            bags,
            [OutputBag(Path(output), chooses, start_ns, end_ns, options=options)],
            as_json=as_json,
        )


def merge_bags(
    bag_paths: BagPaths,
    output: OutputFolder,
    exclude_topics: ExcludeTopics = None,
    as_json: AsJson = False,
    *,
    files: FileOptions,
) -> None:
    """Merge several bags into one, in the order of their times."""
    from teleopctl.bag import OutputBag

    options = files.writer_options()
    excluded = frozenset(exclude_topics or ())
    with _open_bags(bag_paths) as bags:
        merged = OutputBag(Path(output), lambda topic: topic.name not in excluded, options=options)
        _write_bags(bags, [merged], as_json=as_json)


def reindex_bag(bag_path: BagPath, storage: Storage = None, as_json: AsJson = False) -> None:
    """Rebuild a bag's metadata.yaml from its files, and complete files left unfinished.

    Unfinished files are completed first.
    """
    from teleopctl.bag import reindex

    del storage  # the suffixes of the files determine it
    if not Path(bag_path).is_dir():
        raise NotFoundError("Must specify a bag directory")
    console.note(f"Beginning reindexing bag in directory: {bag_path}")
    metadata = reindex(Path(bag_path))
    console.note(f"Reindexing complete: {metadata.message_count} messages.")
    if as_json:
        console.out_json({"bags": [{"folder": bag_path, "messages": metadata.message_count}]})


def check_bag(bag_path: BagPath, as_json: AsJson = False) -> int:
    """Check a whole bag and print its faults; the exit status is 1 if there are any.

    Checks checksums, indexes, metadata.yaml, type definitions and hashes; finds messages that
    cannot be decoded or are missing, and times that go back.
    """
    from teleopctl.bag import check

    with _show_percent() as on_progress:
        findings = list(check(Path(bag_path), on_progress))
    if as_json:
        console.out_json([finding._asdict() for finding in findings])
    elif findings:
        console.out_lines(f"{finding.place}: {finding.what}" for finding in findings)
    else:
        console.out(f"{bag_path}: nothing is wrong")
    return 1 if findings else 0


def recover_bag(
    bag_path: BagPath,
    output: Annotated[
        str | None,
        Option(
            "-o",
            "--output",
            help="Folder for the recovered bag; the damaged bag stays unchanged.",
            metavar="FOLDER",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Recover a bag that is damaged, or whose recorder was killed.

    A truncated bag is completed in place. A damaged bag stays unchanged, and its readable messages
    are copied to a new bag, by default BAG_recovered. The exit status is 1 if messages are lost.
    """
    from teleopctl.bag import recover

    with _show_percent() as on_progress:
        recovery = recover(Path(bag_path), Path(output) if output else None, on_progress)
    if as_json:
        console.out_json(
            {
                "path": str(recovery.path),
                "messages": recovery.message_count,
                "done": recovery.done,
                "damage": recovery.damage,
                "lost": recovery.lost,
            }
        )
    else:
        console.out_lines(recovery.damage)
        console.out_lines(recovery.done or [f"{recovery.path} is whole"])
        console.out_lines(f"Lost: {sentence}" for sentence in recovery.lost)
        console.out(f"{recovery.path} has {recovery.message_count} messages")
    return 1 if recovery.lost else 0


_PROGRESS_PERIOD_S = 0.2


@contextlib.contextmanager
def _open_bags(paths: Iterable[str], storages: Sequence[str | None] = ()) -> "Iterator[list[Bag]]":
    """Open bags, yield them, and print warnings about their faults."""
    from teleopctl.bag import open_bag

    with contextlib.ExitStack() as stack:
        bags = []
        for number, path in enumerate(paths):
            storage = storages[number] if number < len(storages) else None
            bag = stack.enter_context(open_bag(Path(path), storage))
            for remark in bag.remarks:
                console.warn(remark)
            bags.append(bag)
        yield bags


def _input_bags(words_of_flag: list[str], words: list[str], file: str | None) -> "list[InputBag]":
    """Return the input bags, by whichever option named them.

    Args:
        words_of_flag: Values of ``--input``: paths of bags, each optionally followed by its storage
            format.
        words: Paths of further bags.
        file: YAML file of ``--input-options``, or None.

    Raises:
        UsageError: No bag is given, or bags are given both by words and by ``file``.
        TeleopctlError: The file cannot be read or is invalid.
    """
    from dataclasses import replace

    from teleopctl.bag import InputBag, read_input_options

    if file is not None:
        if words_of_flag or words:
            raise UsageError(
                "Exactly one input source must be provided: provide either -i, --input or "
                "--input-options YAML file, but not both."
            )
        found, remarks = read_input_options(Path(file))
        for remark in remarks:
            console.warn(remark)
        return found
    found = []
    for word in words_of_flag:
        is_form = word in _STORAGES and not Path(word).exists()
        if is_form and found and found[-1].storage is None:
            found[-1] = replace(found[-1], storage=word)
        else:
            found.append(InputBag(Path(word)))
    found += [InputBag(Path(word)) for word in words]
    if not found:
        raise UsageError("Name a bag to convert")
    return found


def _write_bags(bags: "Sequence[Bag]", outputs: "Sequence[OutputBag]", *, as_json: bool) -> None:
    """Write the output bags, with _show_percent on a terminal, and print a summary."""
    from teleopctl.bag import copy_bags

    if any(output.options.database_settings is not None for output in outputs):
        files = {attachment.name for bag in bags for attachment in bag.attachments()}
        if files:
            console.warn(f"SQLite bags cannot store {', '.join(sorted(files))}: left out")
    with _show_percent() as on_progress:
        counts = copy_bags(bags, outputs, on_progress)
    written = [
        (output.folder, sum(count.values())) for output, count in zip(outputs, counts, strict=True)
    ]
    console.out_done(
        "\n".join(f"{folder}: {messages} messages" for folder, messages in written),
        as_json=as_json,
        bags=[{"folder": str(folder), "messages": messages} for folder, messages in written],
    )


def _topic_filter(
    topics: list[str] | None,
    services: list[str] | None,
    types: list[str] | None,
    regex: str,
    exclude_regex: str,
    exclude_topics: list[str] | None,
    exclude_types: list[str] | None,
) -> "Callable[[BagTopic], bool]":
    """Return a function that selects topics by the given options."""
    from teleopctl.bag import Selection

    everything = not (topics or services or types or regex)
    selection = Selection(
        all_topics=everything,
        all_services=everything,
        all_actions=everything,
        topics=topics or (),
        services=services or (),
        topic_types=types or (),
        regex=regex,
        exclude_regex=exclude_regex,
        exclude_topics=exclude_topics or (),
        exclude_topic_types=exclude_types or (),
    )

    def chooses(topic: "BagTopic") -> bool:
        # A topic given by name is selected, even if it belongs to an action or a service.
        named = topic.name in selection.topics and topic.name not in selection.exclude_topics
        return named or selection.chooses(topic.name, topic.type_name)

    return chooses


def _require_topics(bags: "Sequence[Bag]", names: Iterable[str]) -> None:
    """Raise for names of topics that no bag has.

    Raises:
        NotFoundError: No bag has a topic of a given name.
    """
    known = {topic.name for bag in bags for topic, _ in bag.metadata.topics}
    for name in names:
        if name not in known:
            raise NotFoundError(
                f"{bags[0].path} has no topic '{name}'",
                hint=existing_names_hint("topics", [name], known),
            )


@contextlib.contextmanager
def _show_percent() -> Iterator[Callable[[float], None]]:
    """Show progress on a terminal; yield the function to call with the fraction done."""
    import time

    if not sys.stderr.isatty():
        yield lambda _part: None
        return
    due_s = time.monotonic() + _PROGRESS_PERIOD_S
    shown = False

    def tell(part: float) -> None:
        nonlocal due_s, shown
        if time.monotonic() >= due_s:
            sys.stderr.write(f"\r{100 * min(1, max(0, part)):3.0f} %")
            sys.stderr.flush()
            due_s, shown = time.monotonic() + _PROGRESS_PERIOD_S, True

    try:
        yield tell
    finally:
        if shown:
            sys.stderr.write("\r     \r")
            sys.stderr.flush()
