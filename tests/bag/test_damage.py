"""Whatever is done to the bytes of a bag: what looks at it or repairs it says so, and ends."""

from __future__ import annotations

import contextlib
import random
import shutil
import struct
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from teleopctl.bag import (
    BagMessage,
    BagWriter,
    Compression,
    McapFileReader,
    WriterOptions,
    check,
    finish_file,
    open_bag,
    recover,
    reindex,
)
from teleopctl.errors import InvalidFileError, RefusedError, TeleopctlError
from tests.bag.bags import STRING, message, topic, write_bag
from tests.samples import sample

CHUNKED = WriterOptions(chunk_bytes=400)
# Times that are read from broken files are any; nothing that is small needs more than this.
MOST_BYTES = 30_000_000


def read(path: Path) -> list[BagMessage]:
    with open_bag(path) as bag:
        return list(bag.messages())


def place_of(message: BagMessage) -> tuple[str, int]:
    return message.topic, message.log_time_ns


def findings(path: Path) -> list[str]:
    return [f"{place}: {what}" for place, what in check(path)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A bag in several chunks of each compression, and its messages."""
    bags = {}
    for compression in Compression:
        folder = tmp_path_factory.mktemp("whole") / "bag"
        options = WriterOptions(compression=compression, chunk_bytes=400)
        bags[compression] = (folder, write_bag(folder, count=40, topics=1, options=options))
    return bags


def copied(folder: Path, to: Path) -> Path:
    shutil.rmtree(to, ignore_errors=True)
    shutil.copytree(folder, to)
    return next(to.glob("*.mcap"))


def test_a_bag_of_ours_has_nothing_wrong(whole):
    for folder, _ in whole.values():
        assert findings(folder) == []


@pytest.mark.parametrize("compression", sample(Compression, 3))
def test_wherever_a_writer_was_killed_recover_makes_the_bag_whole(whole, tmp_path, compression):
    folder, written = whole[compression]
    size = copied(folder, tmp_path / "bag").stat().st_size
    found = []
    for end in range(0, size, 97):
        file = copied(folder, tmp_path / "bag")
        with file.open("r+b") as stream:
            stream.truncate(end)
        recovery = recover(tmp_path / "bag")
        assert recovery.lost == []
        messages = read(tmp_path / "bag")
        assert messages == written[: len(messages)]
        assert findings(tmp_path / "bag") == []
        found.append(len(messages))
    assert found == sorted(found)
    assert found[-1] == len(written)


@pytest.mark.parametrize("compression", Compression)
def test_of_a_chunk_that_was_cut_off_the_whole_messages_are_kept(tmp_path, compression):
    noise = random.Random(1)
    written = [message("/x", n, STRING, data=noise.randbytes(500).hex()) for n in range(500)]
    with BagWriter(tmp_path / "bag", WriterOptions(compression=compression)) as writer:
        writer.add_topic(topic("/x"))
        for each in written:
            writer.write(each)
    (file,) = (tmp_path / "bag").glob("*.mcap")
    (chunk,) = chunks_of(file)
    with file.open("r+b") as stream:
        stream.truncate(chunk + (file.stat().st_size - chunk) * 2 // 3)
    assert read(tmp_path / "bag") == []
    anew = recover(tmp_path / "bag", tmp_path / "anew")
    in_place = recover(tmp_path / "bag")
    for recovery in (anew, in_place):
        saved = read(recovery.path)
        # The compressions keep blocks of up to 128 KiB, of which the last one is lost.
        assert 200 < len(saved) < 400
        assert saved == written[: len(saved)]
        assert any("its checksum cannot be compared" in told for told in recovery.done)
        assert findings(recovery.path) == []
    assert anew.message_count == in_place.message_count


MUTATIONS = st.lists(
    st.tuples(
        st.floats(0, 1), st.sampled_from(["flip", "put", "cut", "zero"]), st.binary(max_size=9)
    ),
    min_size=1,
    max_size=4,
)


def mutated(data: bytes, mutations: list[tuple[float, str, bytes]]) -> bytes:
    changed = bytearray(data)
    for place, kind, more in mutations:
        offset = int(place * len(changed))
        if kind == "flip" and offset < len(changed):
            changed[offset] ^= 1 << len(more) % 8
        elif kind == "put":
            changed[offset : offset + len(more)] = more
        elif kind == "cut":
            del changed[offset:]
        else:
            changed[offset : offset + 40] = bytes(len(changed[offset : offset + 40]))
    return bytes(changed)


@given(st.sampled_from(Compression), MUTATIONS)
def test_damaged_files_raise_nothing_but_our_errors(
    tmp_path_factory, whole, compression, mutations
):
    folder, written = whole[compression]
    place = tmp_path_factory.mktemp("damaged")
    file = copied(folder, place / "bag")
    file.write_bytes(mutated(file.read_bytes(), mutations))
    try:
        found = findings(place / "bag")
        recovery = recover(place / "bag")
        messages = read(recovery.path)
    except TeleopctlError:
        return
    places = {place_of(message): message for message in written}
    for read_message in messages:
        # What is taken over from a broken chunk may say something else, and this is told; where
        # the file ends in it, no index says where a message belongs.
        is_told = any("their content may have changed" in sentence for sentence in recovery.done)
        is_cut = any("checksum cannot be compared" in sentence for sentence in recovery.done)
        assert is_cut or place_of(read_message) in places
        assert is_told or read_message in written
    # The times of a broken chunk's head are not covered by its checksum: order may be lost. What is
    # taken over from the chunk may have another hash than it says.
    tolerated = ("the clock was set back", "its definition has the hash")
    left = [f for f in findings(recovery.path) if not any(words in f for words in tolerated)]
    assert left == []
    if len(messages) < len(written):
        assert found


@given(st.binary(max_size=300), st.sampled_from([".mcap", ".db3", ".bag"]), st.booleans())
def test_bytes_that_are_no_bag_raise_nothing_but_our_errors(tmp_path_factory, data, suffix, magic):
    file = tmp_path_factory.mktemp("random") / f"x{suffix}"
    file.write_bytes((b"\x89MCAP0\r\n" if magic else b"") + data)
    for look in (findings, read, recover):
        with contextlib.suppress(TeleopctlError):
            look(file)


@given(st.floats(0, 1), st.sampled_from([b"\xff" * 8, b"\xff" * 4, b"\xff\xff\xff\x7f"]))
def test_absurd_lengths_take_no_memory(tmp_path_factory, whole, place, absurd):
    folder, _ = whole[Compression.ZSTD]
    file = copied(folder, tmp_path_factory.mktemp("absurd") / "bag")
    data = bytearray(file.read_bytes())
    offset = int(place * (len(data) - len(absurd)))
    data[offset : offset + len(absurd)] = absurd
    file.write_bytes(data)
    tracemalloc.start()
    try:
        findings(file.parent)
        read(file.parent)
    except TeleopctlError:
        pass
    finally:
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert most < MOST_BYTES


def chunks_of(file: Path) -> list[int]:
    """Where the chunks of a file are."""
    data = file.read_bytes()
    offset, found = 8, []
    while offset < len(data) - 8:
        opcode, length = struct.unpack_from("<BQ", data, offset)
        if opcode == 6:
            found.append(offset)
        offset += 9 + length
    return found


def test_a_broken_chunk_costs_its_messages_and_no_others(tmp_path):
    written = write_bag(tmp_path / "bag", count=40, topics=1, options=CHUNKED)
    file = tmp_path / "bag" / "bag_0.mcap"
    second = chunks_of(file)[1]
    data = bytearray(file.read_bytes())
    data[second + 60] ^= 1
    file.write_bytes(data)
    assert any(f"the chunk at byte {second}: " in finding for finding in findings(file.parent))
    recovery = recover(tmp_path / "bag")
    saved = read(tmp_path / "bag_recovered")
    assert recovery.path == tmp_path / "bag_recovered"
    assert 0 < len(saved) < 40
    assert set(saved) < set(written)
    lost = 40 - len(saved)
    assert sum(int(s.split()[1]) for s in recovery.lost if s.startswith("/topic_")) == lost
    assert file.read_bytes() == bytes(data), "the original is left alone"


@pytest.mark.parametrize("compression", sample(Compression, 3))
def test_of_a_chunk_with_a_wrong_checksum_what_is_still_a_message_is_saved(
    whole, tmp_path, compression
):
    folder, written = whole[compression]
    file = copied(folder, tmp_path / "bag")
    data = file.read_bytes()
    begin, end = chunks_of(file)[1:3]
    saved_of_all = set()
    for place in range(begin + 49, end, 13):
        changed = bytearray(data)
        changed[place] ^= 4
        file.write_bytes(changed)
        shutil.rmtree(tmp_path / "bag_recovered", ignore_errors=True)
        recovery = recover(tmp_path / "bag", tmp_path / "bag_recovered")
        saved = read(recovery.path)
        assert findings(recovery.path) == []
        saved_of_all.add(len(saved))
        assert {place_of(message) for message in saved} <= {place_of(m) for m in written}
        # One bit is in one message: a second one that is another is not the first's fault.
        assert len(set(saved) - set(written)) <= (1 if compression is Compression.NONE else 40)
        if any("its checksum is wrong" in finding for finding in findings(tmp_path / "bag")):
            assert any("checksum is wrong" in told for told in (*recovery.done, *recovery.lost))
    if compression is Compression.NONE:
        # Of one message the head is broken, or nothing at all but what it says.
        assert saved_of_all == {39, 40}


@pytest.mark.parametrize("compression", sample(Compression, 3))
@pytest.mark.parametrize("ends_in_chunk", [True, False])
def test_of_a_chunk_that_the_power_left_as_zeros_what_stands_before_is_saved(
    tmp_path, compression, ends_in_chunk
):
    dice = random.Random(1)
    written = [message("/x", n, data=dice.randbytes(100).hex()) for n in range(4500)]
    with BagWriter(tmp_path / "bag", WriterOptions(compression, 600_000)) as writer:
        writer.add_topic(topic("/x"))
        for each in written:
            writer.write(each)
        writer.flush()
        data = (tmp_path / "bag" / "bag_0.mcap").read_bytes()
    file = tmp_path / "bag" / "bag_0.mcap"
    last, end = chunks_of(file)[-1], len(data)
    zeros_from = last + (end - last) // 2
    data = data[:zeros_from] + bytes(end - zeros_from + (-2000 if ends_in_chunk else 1000))
    file.write_bytes(data)
    recovery = recover(tmp_path / "bag")
    saved = read(tmp_path / "bag")
    assert recovery.lost == []
    assert saved == written[: len(saved)]
    before = sum(1 for _ in read_up_to(file, data[:last], tmp_path))
    assert before < len(saved) < len(written)
    assert any(f"{len(saved) - before} of them from a chunk" in done for done in recovery.done)
    assert findings(tmp_path / "bag") == []


def read_up_to(file: Path, data: bytes, folder: Path) -> list[BagMessage]:
    """What a file has up to somewhere."""
    part = folder / file.name
    part.write_bytes(data)
    return read(part)


def test_reindex_opens_no_finished_file_for_writing(tmp_path, monkeypatch):
    write_bag(tmp_path / "bag")
    modes = []
    path_open = Path.open

    def noted(path, mode="r", *args, **kwargs):
        if path.suffix == ".mcap":
            modes.append(mode)
        return path_open(path, mode, *args, **kwargs)

    monkeypatch.setattr(Path, "open", noted)
    reindex(tmp_path / "bag")
    assert set(modes) == {"rb"}


def test_where_the_chain_of_records_is_broken_what_follows_is_found(tmp_path):
    written = write_bag(tmp_path / "bag", count=40, topics=1, options=CHUNKED)
    file = tmp_path / "bag" / "bag_0.mcap"
    second = chunks_of(file)[1]
    data = bytearray(file.read_bytes())
    # No end, no summary, and a record whose length is nonsense.
    data = data[: chunks_of(file)[-1]]
    data[second + 1 : second + 9] = b"\xff" * 8
    file.write_bytes(data)
    with pytest.raises(InvalidFileError, match=f"not only cut off, but broken at byte {second}"):
        finish_file(file)
    recovery = recover(tmp_path / "bag", tmp_path / "out")
    saved = read(tmp_path / "out")
    assert any(f"bytes from byte {second} on belong to no record" in s for s in recovery.lost)
    assert saved[0] == written[0]
    assert saved[-1].sequence > 20
    assert file.read_bytes() == bytes(data)


def test_a_file_that_is_being_written_is_left_to_its_writer(tmp_path):
    with BagWriter(tmp_path / "bag", CHUNKED) as writer:
        writer.add_topic(topic("/x"))
        writer.write(message("/x", 0))
        writer.flush()
        with pytest.raises(RefusedError, match="is being written by another program"):
            reindex(tmp_path / "bag")
        writer.write(message("/x", 1))
    assert len(read(tmp_path / "bag")) == 2


def test_reindex_makes_metadata_anew(tmp_path):
    write_bag(tmp_path / "bag", options=WriterOptions(split_bytes=1000, chunk_bytes=300))
    metadata = tmp_path / "bag" / "metadata.yaml"
    before = metadata.read_text(encoding="utf-8")
    for spoil in (metadata.unlink, lambda: metadata.write_text("nonsense: [", encoding="utf-8")):
        spoil()
        reindex(tmp_path / "bag")
        assert metadata.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("message_count: 40", "message_count: 41"), "bag_0.mcap: message count is 41 in"),
        (("/topic_1", "/topic_7"), "only metadata.yaml has /topic_7"),
        (
            ("std_msgs/msg/String", "std_msgs/msg/Empty"),
            "type is std_msgs/msg/Empty in",
        ),
        (("bag_0.mcap", "bag_5.mcap"), "bag_0.mcap is not listed"),
    ],
)
def test_check_holds_metadata_against_the_files(tmp_path, change, told):
    write_bag(tmp_path / "bag", count=40)
    metadata = tmp_path / "bag" / "metadata.yaml"
    metadata.write_text(metadata.read_text("utf-8").replace(*change), encoding="utf-8")
    assert any(told in finding for finding in findings(tmp_path / "bag"))


def test_check_reads_every_message_and_every_number(tmp_path):
    wrong_hash = topic("/wrong")._replace(type_hash="RIHS01_" + "0" * 64)
    no_text = topic("/none")
    no_text = no_text._replace(definition=no_text.definition._replace(text="strin data"))
    with BagWriter(tmp_path / "bag") as writer:
        for described in (topic("/x")._replace(is_counted=True), wrong_hash, no_text):
            writer.add_topic(described)
        for number in (1, 2, 5, 6):
            writer.write(message("/x", number))
        writer.write(message("/x", 7)._replace(data=b"\0\1\0\0\xff\0\0\0x"))
    found = findings(tmp_path / "bag")
    assert any("/x: 1 messages cannot be decoded, the first at 17000000000070" in f for f in found)
    assert any(f.startswith("/x: 2 messages were sent and are missing") for f in found)
    assert any(f.startswith("/wrong: its definition has the hash RIHS01_df668") for f in found)
    assert any(f.startswith("/none: ") for f in found)
    assert len(found) == 4


def test_readers_of_several_files_survive_one_that_is_lost(tmp_path):
    write_bag(tmp_path / "bag", options=WriterOptions(split_bytes=1000, chunk_bytes=300))
    lost = sorted((tmp_path / "bag").glob("*.mcap"))[1]
    with McapFileReader(lost) as reader:
        count = reader.description.message_count
    lost.write_bytes(b"")
    with open_bag(tmp_path / "bag") as bag:
        assert len(list(bag.messages())) == 100 - count
        assert any("it is left out" in remark for remark in bag.remarks)


def test_a_clock_that_was_set_back_is_told_and_is_no_damage(tmp_path):
    with BagWriter(tmp_path / "bag", CHUNKED) as writer:
        writer.add_topic(topic("/x"))
        for number, time in enumerate([0, 100, 50, 60, 95, 200], start=1):
            writer.write(message("/x", time)._replace(sequence=number))
    (finding,) = findings(tmp_path / "bag")
    assert "the times of 2 messages are before those of earlier ones of their topic" in finding
    assert recover(tmp_path / "bag").done == []
