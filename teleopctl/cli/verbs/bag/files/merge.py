"""``teleopctl bag merge``."""

from pathlib import Path

from teleopctl.cli.options import AsJson
from teleopctl.cli.verbs.bag.options import (
    BagPaths,
    CompressionName,
    ExcludeTopics,
    MaxBagDuration,
    MaxBagSize,
    OutputFolder,
)


def merge_bags(
    bag_paths: BagPaths,
    output: OutputFolder,
    exclude_topics: ExcludeTopics = None,
    compression: CompressionName = "zstd",
    max_bag_size: MaxBagSize = 0,
    max_bag_duration: MaxBagDuration = 0.0,
    as_json: AsJson = False,
) -> None:
    """Write one bag from several, in the order of their times."""
    from teleopctl.bag import OutputBag
    from teleopctl.cli.verbs.bag.files import writing

    options = writing.writer_options(compression, max_bag_size, max_bag_duration)
    excluded = frozenset(exclude_topics or ())
    with writing.opened(bag_paths) as bags:
        merged = OutputBag(Path(output), lambda topic: topic.name not in excluded, options=options)
        writing.write(bags, [merged], as_json=as_json)
