"""Options of a recorder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from teleopctl.bag.recorder.selection import Selection
from teleopctl.bag.storage.bag_writer import WriterOptions
from teleopctl.errors import UsageError
from teleopctl.node import QoSProfile

CACHE_BYTES = 100 * 2**20
"""What waits for the disk at most: rosbag2's default."""

NODE_NAME = "rosbag2_recorder"
"""The recorder's name in the graph: rosbag2's default."""

_HIGHEST_RATE_HZ = 1000.0


@dataclass(frozen=True)
class RecorderOptions:
    """Options of a recorder: selection, writer, cache, snapshot, discovery and QoS.

    Attributes:
        selection: Which topics, services and actions are recorded.
        writer: How the bag is written.
        cache_bytes: What may wait for the disk; 0 writes to the disk as soon as anything comes.
        cache_duration_s: With ``snapshot``, how far back the memory reaches; 0 for as far as
            ``cache_bytes`` let it.
        snapshot: Keep the newest messages in memory, and write them when a snapshot is taken.
        start_paused: Record nothing before `Recorder.resume`.
        use_sim_time: Messages bear the time of ``/clock``, and none is recorded before it runs.
        discovery: Whether topics that appear later are recorded.
        recording_metadata: Whether the bag holds what is needed to understand it: robot
            descriptions, parameters of every node, versions.
        qos: What topics are subscribed to with, by name, in place of what suits their publishers.
        from_first_message: Listen to all topics at once, rather than to each when the graph shows
            it, so that the first messages of what starts after the recorder are not missed. What
            is not recorded is sent all the same.
        statistics_hz: How often losses are published at most; 0 for never.
        node_name: The recorder's name in the graph.

    Raises:
        UsageError: They contradict each other.
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
