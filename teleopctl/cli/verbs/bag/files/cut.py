"""``teleopctl bag cut``."""

from pathlib import Path

from teleopctl.cli.options import AsJson
from teleopctl.cli.verbs.bag.options import (
    BagPath,
    CompressionName,
    Duration,
    From,
    MaxBagDuration,
    MaxBagSize,
    OutputFolder,
    StartOffset,
    Storage,
    Until,
)
from teleopctl.errors import UsageError


def cut_bag(
    bag_path: BagPath,
    output: OutputFolder,
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
    """Write a bag with a part of the time of another one, that can be played alone.

    It begins with what latched topics, such as /tf_static and /robot_description, had before.
    """
    from teleopctl.bag import OutputBag
    from teleopctl.cli.verbs.bag.files import writing

    if start_offset is None and duration is None and start is None and until is None:
        raise UsageError("Say what to keep: --start-offset or --from, --duration or --until")
    options = writing.writer_options(compression, max_bag_size, max_bag_duration)
    with writing.opened([bag_path], [storage]) as bags:
        start_ns, end_ns = writing.time_range(bags, start_offset, duration, start, until)
        cut = OutputBag(
            Path(output), start_ns=start_ns, end_ns=end_ns, continues_latched=True, options=options
        )
        writing.write(bags, [cut], as_json=as_json)
