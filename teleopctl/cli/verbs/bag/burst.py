"""``teleopctl bag burst``."""

from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath, Storage
from teleopctl.cli.verbs.bag.play_options import (
    Actions,
    QosOverrides,
    ReadAhead,
    Remaps,
    Services,
    StartOffset,
    StorageConfig,
    Topics,
    check_common,
    overrides_from,
)
from teleopctl.errors import UsageError
from teleopctl.interfaces import from_seconds


def burst(
    bag_path: BagPath,
    num_messages: Annotated[
        int,
        Option("-n", "--num-messages", help="Send so many messages; 0 for all.", metavar="N"),
    ] = 0,
    topics: Topics = None,
    services: Services = None,
    actions: Actions = None,
    start_offset: StartOffset = 0.0,
    remap: Remaps = None,
    qos_overrides: QosOverrides = None,
    read_ahead: ReadAhead = 1000,
    storage: Storage = None,
    storage_config_file: StorageConfig = None,
) -> int:
    """Send messages of a bag as fast as they can be read, then pause.

    The keys and services of `bag play` go on from there; Ctrl-C ends it.
    """
    check_common(read_ahead, start_offset, storage_config_file)
    if num_messages < 0:
        raise UsageError(f"--num-messages {num_messages}: Value is less than zero.")
    from teleopctl.bag import PlayOptions, PlaySelection
    from teleopctl.cli.verbs.bag.playing import Terminal, play_bags

    options = PlayOptions(
        is_paused=True,
        is_lossless=True,
        start_offset_ns=from_seconds(start_offset),
        selection=PlaySelection(tuple(topics or ()), tuple(services or ()), tuple(actions or ())),
        qos_overrides=overrides_from(qos_overrides),
        read_ahead=read_ahead,
    )
    bags = [(Path(bag_path), storage)]
    return play_bags(bags, options, remap or [], Terminal(), burst=num_messages)
