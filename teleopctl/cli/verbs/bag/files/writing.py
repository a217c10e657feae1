"""What the verbs that write bags from bags share."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from teleopctl.bag import (
    Compression,
    InputBag,
    OutputBag,
    Selection,
    WriterOptions,
    copy_bags,
    database_settings,
    open_bag,
    read_inputs,
)
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console
from teleopctl.errors import NotFoundError, UsageError, what_there_is
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, from_seconds

if TYPE_CHECKING:
    from teleopctl.bag import Bag, BagTopic

_STORAGES = ("mcap", "sqlite3")
_PROGRESS_PERIOD_S = 0.2


@contextlib.contextmanager
def opened(paths: Iterable[str], storages: Sequence[str | None] = ()) -> Iterator[list[Bag]]:
    """Open bags, and print warnings about their faults."""
    with contextlib.ExitStack() as stack:
        bags = []
        for number, path in enumerate(paths):
            storage = storages[number] if number < len(storages) else None
            bag = stack.enter_context(open_bag(Path(path), storage))
            for remark in bag.remarks:
                console.warn(remark)
            bags.append(bag)
        yield bags


def inputs(words_of_flag: list[str], words: list[str], file: str | None) -> list[InputBag]:
    """Return the input bags, by whichever option named them.

    Args:
        words_of_flag: What stood behind ``--input``: bags, and forms of the files of the last one.
        words: Bags.
        file: That of ``--input-options``.

    Raises:
        UsageError: None is named, or in both ways.
        TeleopctlError: Something is wrong with the file.
    """
    if file is not None:
        if words_of_flag or words:
            raise UsageError(
                "Exactly one input source must be provided: provide either -i, --input or "
                "--input-options YAML file, but not both."
            )
        found, remarks = read_inputs(Path(file))
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


def write(bags: Sequence[Bag], outputs: Sequence[OutputBag], *, as_json: bool) -> None:
    """Write the output bags, with progress on a terminal, and print a summary."""
    if any(output.options.database_settings is not None for output in outputs):
        files = {attachment.name for bag in bags for attachment in bag.attachments()}
        if files:
            console.warn(f"A database has no place for {', '.join(sorted(files))}: left out")
    with progress() as told:
        counts = copy_bags(bags, outputs, told)
    written = [
        (output.folder, sum(count.values())) for output, count in zip(outputs, counts, strict=True)
    ]
    console.out_done(
        "\n".join(f"{folder}: {messages} messages" for folder, messages in written),
        as_json=as_json,
        bags=[{"folder": str(folder), "messages": messages} for folder, messages in written],
    )


def writer_options(
    compression: str, max_bag_size: int, max_bag_duration: float, storage: str = "mcap"
) -> WriterOptions:
    """Return the writer options of the command line."""
    if max_bag_size < 0 or max_bag_duration < 0:
        raise UsageError("Size and duration of a file cannot be negative")
    return WriterOptions(
        compression=Compression(compression),
        database_settings=database_settings() if storage == "sqlite3" else None,
        split_bytes=max_bag_size,
        split_duration_ns=from_seconds(max_bag_duration),
    )


def chooser(
    topics: list[str] | None,
    services: list[str] | None,
    types: list[str] | None,
    regex: str,
    exclude_regex: str,
    exclude_topics: list[str] | None,
    exclude_types: list[str] | None,
) -> Callable[[BagTopic], bool]:
    """Return a function that selects topics by the given options."""
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

    def chooses(topic: BagTopic) -> bool:
        # A topic that is named is meant, even one that belongs to an action or a service.
        named = topic.name in selection.topics and topic.name not in selection.exclude_topics
        return named or selection.chooses(topic.name, topic.type_name)

    return chooses


def require_topics(bags: Sequence[Bag], names: Iterable[str]) -> None:
    """Raise for names of topics that no bag has.

    Raises:
        NotFoundError: There is one.
    """
    known = {topic.name for bag in bags for topic, _ in bag.metadata.topics}
    for name in names:
        if name not in known:
            raise NotFoundError(
                f"{bags[0].path} has no topic '{name}'",
                hint=what_there_is("topics", [name], known),
            )


def time_range(
    bags: Sequence[Bag],
    start_offset: float | None,
    duration: float | None,
    start: float | None,
    until: float | None,
) -> tuple[int, int]:
    """Return the first and last log time of the selected range, in nanoseconds."""
    if start_offset is not None and start is not None:
        raise UsageError("--start-offset and --from say the same thing; give one of them")
    if duration is not None and until is not None:
        raise UsageError("--duration and --until say the same thing; give one of them")
    if (start_offset or 0) < 0 or (duration or 0) < 0:
        raise UsageError("--start-offset and --duration cannot be negative")
    filled = [bag.metadata for bag in bags if bag.metadata.message_count]
    first_ns = min((metadata.start_ns for metadata in filled), default=0)
    end_ns = max((metadata.end_ns for metadata in filled), default=0) + 1
    length_s = max(0, end_ns - 1 - first_ns) / NANOSECONDS_PER_SECOND
    start_ns = first_ns + from_seconds(start_offset or 0)
    if start is not None:
        start_ns = max(0, from_seconds(start))
    if duration is not None:
        end_ns = start_ns + from_seconds(duration)
    elif until is not None:
        end_ns = from_seconds(until)
    if end_ns <= start_ns:
        raise UsageError(
            f"That leaves no time: the bag lasts {length_s:.3f} s",
            hint="teleopctl bag info BAG shows from when to when it goes.",
        )
    return start_ns, end_ns


@contextlib.contextmanager
def progress() -> Iterator[Callable[[float], None]]:
    """Show progress on a terminal; yield the function to call with the fraction done."""
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
