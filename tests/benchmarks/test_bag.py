"""The recorder's way from its queue to the disk, against the mcap library's writer fed from memory.

Both get the same messages in the same run, and write chunks of the same size. What the recorder
does besides is its queue and its thread, the counts of its topics, and ``metadata.yaml``.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from teleopctl.bag import BagMessage, BagWriter, Compression, WriterOptions
from teleopctl.bag.mcap_file.chunk_builder import CHUNK_BYTES
from teleopctl.bag.recorder.writing import MessageQueue, WritingThread
from teleopctl.base.kept_memory import keep_freed_memory
from tests.bag.bags import topic
from tests.benchmarks.figure import Figure

ROUNDS = 3
TOPIC = topic("/x")

# Half of each is noise: neither the best case of a compressor nor its worst.
KINDS = {"joint states": (400, 100_000), "pictures": (2304 * 1296 * 3, 40)}


def messages(size: int, count: int) -> list[BagMessage]:
    data = os.urandom(size // 2) + bytes(size - size // 2)
    return [BagMessage("/x", number, number, data, number) for number in range(count)]


def write_bare(path: Path, compression: Compression, batch: Sequence[BagMessage]) -> None:
    with path.open("wb", buffering=2**20) as stream:
        writer = Writer(stream, CHUNK_BYTES, CompressionType[compression.name])
        writer.start("ros2")
        schema = writer.register_schema(
            TOPIC.type_name, TOPIC.definition.encoding, TOPIC.definition.text.encode()
        )
        channel = writer.register_channel("/x", "cdr", schema)
        for _, log_time, publish_time, data, sequence, _ in batch:
            writer.add_message(channel, log_time, data, publish_time, sequence)
        writer.finish()


def write_recorded(folder: Path, compression: Compression, batch: Sequence[BagMessage]) -> None:
    queue = MessageQueue(2**40)
    writer = BagWriter(folder, WriterOptions(compression=compression))
    thread = WritingThread(writer, queue, None, lambda error: pytest.fail(error.message))
    thread.add_topic(TOPIC)
    for message in batch:
        assert queue.put(message)
    thread.close()


def cost_s(write: Callable[[], object]) -> float:
    begun = time.process_time()
    write()
    return time.process_time() - begun


@pytest.mark.parametrize("compression", Compression)
@pytest.mark.parametrize("kind", KINDS)
def test_recording_beside_the_library_alone(kind, compression, tmp_path, figures: list[Figure]):
    keep_freed_memory()  # as the command does; the library alone gains by it as well
    batch = messages(*KINDS[kind])
    bare: list[float] = []
    recorded: list[float] = []
    for number in range(ROUNDS):
        file, folder = tmp_path / f"{number}.mcap", tmp_path / f"bag_{number}"
        bare.append(cost_s(partial(write_bare, file, compression, batch)))
        recorded.append(cost_s(partial(write_recorded, folder, compression, batch)))
        file.unlink()
        for written in folder.iterdir():
            written.unlink()
    size_mb = sum(len(message.data) for message in batch) / 1e6
    best = min(recorded)
    figures.append(
        Figure(
            f"record {kind}, compression {compression.value}",
            f"{size_mb / best:.0f} MB/s, {len(batch) / best:.0f} messages/s of processor time",
            f"mcap library alone: {size_mb / min(bare):.0f} MB/s",
            best / min(bare),
        )
    )
