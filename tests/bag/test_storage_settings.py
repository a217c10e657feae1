"""rosbag2's settings of MCAP files: each is done, or refused with its line."""

from __future__ import annotations

import os

import pytest
from mcap.reader import make_reader

from teleopctl.bag import (
    BagMessage,
    BagWriter,
    ChunkSettings,
    Compression,
    CompressionLevel,
    WriterOptions,
    chunk_settings,
)
from teleopctl.errors import InvalidFileError, TeleopctlError, UnsupportedError, UsageError
from tests.bag.bags import topic


@pytest.fixture
def read(tmp_path):
    def read(text: str, preset: str = "") -> ChunkSettings:
        file = tmp_path / "mcap.yaml"
        file.write_text(text, encoding="utf-8")
        return chunk_settings(preset, file)

    return read


def test_presets_are_the_compressions_of_rosbag2():
    assert chunk_settings() == ChunkSettings(Compression.ZSTD)
    assert chunk_settings("none") == chunk_settings("fastwrite") == ChunkSettings(Compression.NONE)
    fast, small = chunk_settings("zstd_fast"), chunk_settings("zstd_small")
    assert (fast.compression, fast.compression_level) == (
        Compression.ZSTD,
        CompressionLevel.FASTEST,
    )
    assert (small.compression_level, small.chunk_bytes) == (CompressionLevel.SLOWEST, 4 * 2**20)
    with pytest.raises(UsageError, match="unknown MCAP storage preset profile 'small'"):
        chunk_settings("small")


def test_a_file_wins_over_the_preset_and_each_of_its_keys_counts(read):
    assert read("", "none") == ChunkSettings(Compression.NONE)
    assert read(
        "compression: Lz4\ncompressionLevel: Slow\nchunkSize: 7\nforceCompression: true\n"
        "noChunkCRC: true\nnoChunking: false\n",
        "zstd_small",
    ) == ChunkSettings(Compression.LZ4, 7, CompressionLevel.SLOW, True, False)


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("\nnoChunking: true", UnsupportedError, ":2: 'noChunking' is not supported: files always"),
        ("noSummaryCRC: true", UnsupportedError, ":1: 'noSummaryCRC' is not supported"),
        ("enableDataCRC: true", UnsupportedError, ":1: 'enableDataCRC' is not supported"),
        ("chunksize: 3", InvalidFileError, ":1: 'chunksize' is not known"),
        ("chunkSize: many", InvalidFileError, ":1: 'chunkSize' is a number of bytes, not 'many'"),
        ("compression: bz2", InvalidFileError, ":1: 'compression' is None, Lz4, Zstd, not 'bz2'"),
        ("compressionLevel: 9", InvalidFileError, ":1: 'compressionLevel' is Fastest, Fast, Def"),
        (
            "noChunkCRC: never",
            InvalidFileError,
            ":1: 'noChunkCRC' must be true or false, not 'never'",
        ),
        ("a: }", InvalidFileError, ":1: not YAML"),
        ("- a", InvalidFileError, "mcap.yaml is no mapping of settings"),
    ],
)
def test_what_is_not_done_is_refused_with_its_line(read, text, kind, message):
    with pytest.raises(TeleopctlError) as refused:
        read(text)
    assert isinstance(refused.value, kind)
    assert message in refused.value.message


@pytest.mark.parametrize("forces", [False, True])
def test_noise_is_compressed_only_where_that_is_forced(tmp_path, forces):
    options = WriterOptions(forces_compression=forces, chunk_checksums=forces)
    with BagWriter(tmp_path / "bag", options) as writer:
        writer.add_topic(topic("/x"))
        writer.write(BagMessage("/x", 1, 1, os.urandom(100_000), 1))
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
        assert summary is not None
        (chunk,) = summary.chunk_indexes
        stream.seek(chunk.chunk_start_offset + 9 + 24)
        checksum = int.from_bytes(stream.read(4), "little")
    assert chunk.compression == ("zstd" if forces else "")
    assert bool(checksum) == forces
