"""``teleopctl bag filter``."""

from pathlib import Path

from teleopctl.cli.options import AsJson
from teleopctl.cli.verbs.bag.options import (
    BagPath,
    ChosenServices,
    ChosenTopics,
    ChosenTypes,
    CompressionName,
    Duration,
    ExcludeRegex,
    ExcludeTopics,
    ExcludeTypes,
    From,
    MaxBagDuration,
    MaxBagSize,
    OutputFolder,
    Regex,
    StartOffset,
    Storage,
    Until,
)


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
    start_offset: StartOffset = None,
    duration: Duration = None,
    start: From = None,
    until: Until = None,
    compression: CompressionName = "zstd",
    max_bag_size: MaxBagSize = 0,
    max_bag_duration: MaxBagDuration = 0.0,
    storage: Storage = None,
    as_json: AsJson = False,
) -> None:
    """Write a bag with some of the topics of another one, or some of its time.

    The messages that were chosen are kept as they are, and so are attachments, profiles and
    definitions. Without a choice of topics all are taken but those that are excluded.
    """
    from teleopctl.bag import OutputBag
    from teleopctl.cli.verbs.bag.files import writing

    options = writing.writer_options(compression, max_bag_size, max_bag_duration)
    chooses = writing.chooser(
        topics,
        services,
        topic_types,
        regex,
        exclude_regex,
        exclude_topics,
        exclude_topic_types,
    )
    with writing.opened([bag_path], [storage]) as bags:
        writing.require_topics(bags, topics or ())
        start_ns, end_ns = writing.time_range(bags, start_offset, duration, start, until)
        writing.write(
            bags,
            [OutputBag(Path(output), chooses, start_ns, end_ns, options=options)],
            as_json=as_json,
        )
