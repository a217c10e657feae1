"""What ``metadata.yaml`` says, held against what the files have."""

from __future__ import annotations

from collections.abc import Iterator

from teleopctl.bag.metadata import BagMetadata


def disagreements(said: BagMetadata, found: BagMetadata) -> Iterator[str]:
    """Yield a sentence for each difference between ``metadata.yaml`` and the files.

    Args:
        said: By ``metadata.yaml``.
        found: In the files.
    """
    said_files = {file.path: file for file in said.files}
    found_files = {file.path: file for file in found.files}
    for path in said_files.keys() - found_files.keys():
        yield f"{path} is named and is not there, or cannot be read"
    for path in found_files.keys() - said_files.keys():
        yield f"{path} is not named"
    for path in sorted(said_files.keys() & found_files.keys()):
        yield from _differences(
            path,
            ("messages", said_files[path].message_count, found_files[path].message_count),
            ("ns as start", said_files[path].start_ns, found_files[path].start_ns),
            ("ns long", said_files[path].duration_ns, found_files[path].duration_ns),
        )
    said_topics = {topic.name: (topic, count) for topic, count in said.topics}
    found_topics = {topic.name: (topic, count) for topic, count in found.topics}
    for name in sorted(said_topics.keys() ^ found_topics.keys()):
        where = "the files" if name in found_topics else "metadata.yaml"
        yield f"only {where} have {name}" if name in found_topics else f"only {where} has {name}"
    for name in sorted(said_topics.keys() & found_topics.keys()):
        (said_topic, said_count), (found_topic, count) = said_topics[name], found_topics[name]
        yield from _differences(name, ("messages", said_count, count))
        if said_topic.type_name != found_topic.type_name:
            yield f"{name} is said to be {said_topic.type_name} and is {found_topic.type_name}"


def _differences(name: str, *pairs: tuple[str, int, int]) -> Iterator[str]:
    for what, said, found in pairs:
        if said != found:
            yield f"{name}: {said} {what} are said, {found} are there"
