"""Our MCAP files are those of the mcap library's writer, byte for byte."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import lz4.frame  # type: ignore[import-untyped]  # it has no stubs
import pytest
import zstandard
from hypothesis import given, strategies as st
from mcap.reader import make_reader
from mcap.summary import Summary
from mcap.writer import CompressionType, Writer

from teleopctl.bag import BagAttachment, BagMessage, ChunkSettings, Compression, CompressionLevel
from teleopctl.bag.mcap_file.file_writer import LIBRARY, McapFileWriter
from teleopctl.bag.qos_profiles import format_offered_profiles
from tests.bag.bags import topic

NAMES = ("/a", "/b", "/c")
BIG = 2**64 - 1
MESSAGES = st.builds(
    lambda name, log_ns, publish_ns, data, number: BagMessage(
        name, log_ns, publish_ns, data, number
    ),
    st.sampled_from(NAMES),
    st.integers(0, BIG),
    st.integers(0, BIG),
    st.binary(max_size=200),
    st.integers(0, 2**32 - 1),
)
ATTACHMENTS = st.builds(
    BagAttachment,
    st.text(max_size=9),
    st.text(max_size=9),
    st.binary(max_size=50),
    st.integers(0, BIG),
)
RECORDS = st.tuples(st.text(max_size=9), st.dictionaries(st.text(max_size=9), st.text(max_size=9)))
STEPS = st.lists(st.one_of(MESSAGES, ATTACHMENTS, RECORDS, st.just("flush")), max_size=40)


def written_by_us(path: Path, settings: ChunkSettings, steps: list[Any]) -> bytes:
    path.unlink(missing_ok=True)
    writer = McapFileWriter(path, settings)
    for name in NAMES:
        writer.add_topic(topic(name))
    for step in steps:
        if isinstance(step, BagMessage):
            writer.write(step)
        elif isinstance(step, BagAttachment):
            writer.attach(step)
        elif step == "flush":
            writer.flush()
        else:
            writer.add_record(*step)
    writer.close()
    return path.read_bytes()


def written_by_the_library(chunk_bytes: int, steps: list[Any]) -> bytes:
    stream = io.BytesIO()
    writer = Writer(stream, chunk_bytes, CompressionType.NONE)
    writer.start("ros2", LIBRARY)
    channels = {}
    schema = 0
    for name in NAMES:
        described = topic(name)
        schema = schema or writer.register_schema(
            described.type_name, "ros2msg", described.definition.text.encode()
        )
        offers = format_offered_profiles(described.qos)
        about = {"offered_qos_profiles": offers, "topic_type_hash": described.type_hash}
        channels[name] = writer.register_channel(name, "cdr", schema, about)
    for step in steps:
        if isinstance(step, BagMessage):
            writer.add_message(
                channels[step.topic], step.log_time_ns, step.data, step.publish_time_ns,
                step.sequence,
            )  # fmt: skip
        elif isinstance(step, BagAttachment):
            writer.add_attachment(0, step.log_time_ns, step.name, step.media_type, step.data)
        elif step == "flush":
            writer.flush()
        else:
            writer.add_metadata(*step)
    writer.finish()
    return stream.getvalue()


def summary_of(data: bytes) -> Summary:
    found = make_reader(io.BytesIO(data), validate_crcs=True).get_summary()
    assert found is not None
    return found


@given(STEPS, st.integers(1, 700))
def test_the_data_is_the_librarys_byte_for_byte_and_the_summary_says_the_same(
    tmp_path_factory, steps, chunk_bytes
):
    settings = ChunkSettings(Compression.NONE, chunk_bytes)
    ours = written_by_us(tmp_path_factory.getbasetemp() / "ours.mcap", settings, steps)
    theirs = written_by_the_library(chunk_bytes, steps)
    # The library also writes offsets of parts of the summary that are empty.
    end = len(theirs) - 8 - 29
    summary_start = int.from_bytes(theirs[end + 9 : end + 17], "little")
    assert ours[:summary_start] == theirs[:summary_start]
    assert vars(summary_of(ours)) == vars(summary_of(theirs))


@pytest.mark.parametrize("level", CompressionLevel)
@pytest.mark.parametrize("compression", [Compression.LZ4, Compression.ZSTD])
def test_each_level_of_compression_is_what_the_libraries_make_of_it(tmp_path, compression, level):
    text = b"".join(b"%d %d " % (number, number % 7) for number in range(3000))
    written = BagMessage("/a", 1, 1, text, 1)
    settings = ChunkSettings(compression, compression_level=level)
    data = written_by_us(tmp_path / "x.mcap", settings, [written])
    (chunk,) = summary_of(data).chunk_indexes
    begin = chunk.chunk_start_offset + chunk.chunk_length - chunk.compressed_size
    compressed = data[begin : begin + chunk.compressed_size]
    if compression is Compression.LZ4:
        number = {"Fastest": -1, "Fast": 0, "Default": 0, "Slow": 10, "Slowest": 12}[level.value]
        content = lz4.frame.decompress(compressed)
        expected = lz4.frame.compress(content, compression_level=number)
    else:
        number = {"Fastest": -5, "Fast": -3, "Default": 3, "Slow": 5, "Slowest": 19}[level.value]
        content = zstandard.decompress(compressed)
        expected = zstandard.compress(content, number)
    assert compressed == expected
    (message,) = [
        m for _, _, m in make_reader(io.BytesIO(data), validate_crcs=True).iter_messages()
    ]
    assert message.data == text
