"""Options of a recorder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.bag.recorder.selection import Selection
from teleopctl.bag.storage.bag_writer import WriterOptions
from teleopctl.errors import UsageError
from teleopctl.node import QoSProfile

CACHE_BYTES = 100 * 2**20
"""Largest size of messages waiting to be written, in bytes: rosbag2's default."""

NODE_NAME = "rosbag2_recorder"
"""Name of the recorder's node: rosbag2's default."""

_HIGHEST_RATE_HZ = 1000.0


@dataclass(frozen=True)
class RecorderOptions:
    """Options of a recorder: selection, writer, cache, snapshot, discovery and QoS.

    Attributes:
        selection: Topics, services and actions to record.
        writer: Options of the bag's files.
        cache_bytes: Largest size of messages waiting to be written; 0 writes each message to the
            disk at once.
        cache_duration_s: Time span in seconds that the snapshot buffer holds, with ``snapshot``;
            0 for no limit but ``cache_bytes``.
        snapshot: Whether to keep the newest messages in memory, and write them when a snapshot is
            taken.
        start_paused: Whether to record nothing before `Recorder.resume`.
        use_sim_time: Whether messages get times of ``/clock``; recording starts with its first
            message.
        discovery: Whether topics that appear later are recorded.
        recording_metadata: Whether to add robot descriptions, parameters of every node, and
            versions to the bag.
        qos: QoS profiles of subscriptions by topic, instead of those chosen for the publishers.
        from_first_message: Whether to subscribe to all topics of the domain at once, rather than to
            each topic when it appears in the graph. The first messages of later nodes are then not
            missed, but messages of topics that are not recorded are also transferred.
        logs_topics: Whether each subscription is logged, and what is not recorded.
        statistics_hz: Largest rate at which losses are published, in Hz; 0 for never.
        node_name: Name of the recorder's node.

    Raises:
        UsageError: Options contradict each other, or a value is out of range.
    """

    selection: Selection = field(default_factory=lambda: Selection(all_topics=True))
    writer: WriterOptions = field(default_factory=WriterOptions)
    cache_bytes: int = CACHE_BYTES
    cache_duration_s: float = 0.0
    snapshot: bool = False
    start_paused: bool = False
    use_sim_time: bool = False
    discovery: bool = True
    recording_metadata: bool = True
    qos: Mapping[str, QoSProfile] = field(default_factory=dict)
    from_first_message: bool = False
    logs_topics: bool = True
    statistics_hz: float = 1.0
    node_name: str = NODE_NAME

    def __post_init__(self) -> None:
        if self.selection.is_empty:
            raise UsageError("The selection chooses nothing, so that nothing would be recorded")
        if self.use_sim_time and not self.discovery:
            raise UsageError(
                "Simulated time needs discovery: /clock has to be found before anything is recorded"
            )
        if self.snapshot and not (self.cache_bytes or self.cache_duration_s):
            raise UsageError("A snapshot needs a bound of the memory: in bytes or in seconds")
        if min(self.cache_bytes, self.cache_duration_s) < 0:
            raise UsageError("The bounds of the memory must not be negative")
        if not 0 <= self.statistics_hz <= _HIGHEST_RATE_HZ:
            raise UsageError(f"Statistics are published at 0 to {_HIGHEST_RATE_HZ:g} Hz")
