"""rosbag2's file of outputs is done key by key, or told with its line."""

from __future__ import annotations

import pytest

from teleopctl.bag import BagTopic, Compression, database_settings, read_output_options
from teleopctl.errors import InvalidFileError, UnsupportedError, UsageError


@pytest.fixture
def read(tmp_path):
    def write_and_read(text: str):
        path = tmp_path / "out.yaml"
        path.write_text(text, encoding="utf-8")
        outputs, remarks = read_output_options(path)
        return outputs, [remark.removeprefix(str(path)) for remark in remarks]

    return write_and_read


def names_of(output):
    event = "/add/_service_event"
    topics = [
        BagTopic("/a", "std_msgs/msg/String"),
        BagTopic("/b/a", "std_msgs/msg/Empty"),
        BagTopic("/_hidden", "std_msgs/msg/String"),
        BagTopic(event, "example_interfaces/srv/AddTwoInts_Event"),
    ]
    return [topic.name for topic in topics if output.chooses(topic)]


def test_every_key_of_an_output_is_done(read):
    (output,), remarks = read(
        "output_bags:\n"
        "- uri: there\n"
        "  storage_id: mcap\n"
        "  max_bagfile_size: 1000\n"
        "  max_bagfile_duration: 5\n"
        "  start_time_ns: 10\n"
        "  end_time_ns: 20\n"
        "  custom_data: {who: Ada}\n"
        "  compression_mode: message\n"
        "  compression_format: lz4\n"
        "  all_topics: true\n"
        "  exclude_regex: ^/b\n"
    )
    assert str(output.folder) == "there"
    # rosbag2 takes what was received at that time too.
    assert (output.start_ns, output.end_ns) == (10, 21)
    assert output.options.compression is Compression.LZ4
    assert (output.options.split_bytes, output.options.split_duration_ns) == (1000, 5_000_000_000)
    assert output.options.custom_data == {"who": "Ada"}
    assert names_of(output) == ["/a"]
    assert remarks == [":9: MCAP files are compressed by chunks"]


def test_an_output_may_be_a_database(read):
    (output,), _ = read(
        "output_bags:\n- {uri: x, all: true, storage_id: sqlite3,"
        " storage_preset_profile: resilient}"
    )
    assert output.options.database_settings == database_settings("resilient")


@pytest.mark.parametrize(
    ("choice", "names"),
    [
        ("all: true", ["/a", "/b/a", "/add/_service_event"]),
        ("all_services: true", ["/add/_service_event"]),
        ("services: [/add]", ["/add/_service_event"]),
        ("topics: [/a]", ["/a"]),
        ("topic_types: [std_msgs/msg/Empty]", ["/b/a"]),
        ("regex: a$", ["/a", "/b/a"]),
        ("{all_topics: true, exclude: b}", ["/a"]),
        ("{all_topics: true, include_hidden_topics: true}", ["/a", "/b/a", "/_hidden"]),
        ("{all_topics: true, exclude_topic_types: [std_msgs/msg/Empty]}", ["/a"]),
    ],
)
def test_topics_are_chosen_as_rosbag2_chooses_them(read, choice, names):
    more = choice.strip("{}") if choice.startswith("{") else choice
    (output,), _ = read(f"output_bags:\n- {{uri: x, {more}}}\n")
    assert names_of(output) == names


def test_several_outputs_and_what_has_no_effect_are_told(read):
    outputs, remarks = read(
        "output_bags:\n- uri: a\n  all: true\n  compression_mode: none\n  max_cache_size: 5\n"
        "- uri: b\n"
    )
    assert [output.folder.name for output in outputs] == ["a", "b"]
    assert outputs[0].options.compression is Compression.NONE
    assert remarks == [
        ":5: 'max_cache_size' has no effect when converting",
        ":6: nothing is chosen (all: true chooses everything)",
    ]


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("", InvalidFileError, ":1: expected a mapping"),
        ("output_bags: []", InvalidFileError, ": it has no list 'output_bags'"),
        ("output_bag: []", InvalidFileError, ":1: 'output_bag' is not known"),
        ("output_bags:\n- all: true", InvalidFileError, ":2: an output has no 'uri'"),
        ("output_bags:\n- uri: x\n  al: true", InvalidFileError, ":3: 'al' is not known"),
        ("output_bags:\n- uri: x\n  uri: y", InvalidFileError, ":3: 'uri' is given twice"),
        ("output_bags:\n- uri: 5", InvalidFileError, ":2: 'uri' must be a text, not 5"),
        (
            "output_bags:\n- uri: x\n  topics: /a",
            InvalidFileError,
            ":3: 'topics' must be a list of names, not '/a'",
        ),
        (
            "output_bags:\n- uri: x\n  storage_id: rosbag_v2",
            UnsupportedError,
            ":3: storage_id cannot be 'rosbag_v2': it is mcap or sqlite3",
        ),
        (
            "output_bags:\n- uri: x\n  storage_id: sqlite3\n  compression_mode: file",
            UnsupportedError,
            ":4: compression_mode cannot be 'file': databases are written as they are",
        ),
        (
            "output_bags:\n- uri: x\n  storage_id: sqlite3\n  max_bagfile_size: 9",
            UsageError,
            ":2: A database cannot be as small as 9 bytes",
        ),
        (
            "output_bags:\n- uri: x\n  storage_id: sqlite3\n  storage_preset_profile: zstd_fast",
            UsageError,
            ":4: unknown SQLite storage preset profile 'zstd_fast'",
        ),
        (
            "output_bags:\n- uri: x\n  snapshot_mode: true",
            UnsupportedError,
            ":3: 'snapshot_mode' is not possible when converting",
        ),
        (
            "output_bags:\n- uri: x\n  compression_format: bz2",
            UnsupportedError,
            ":3: compression_format cannot be 'bz2': expected zstd or lz4",
        ),
        ("output_bags:\n- {uri: x, regex: '('}", UsageError, ":2: '(' is not a regular expression"),
        (
            "output_bags:\n- uri: x\n  storage_preset_profile: best",
            UsageError,
            ":3: unknown MCAP storage preset profile 'best'",
        ),
        (
            "output_bags:\n- uri: x\n  storage_config_uri: none.yaml",
            InvalidFileError,
            ":3: Cannot read none.yaml",
        ),
        ("output_bags: [", InvalidFileError, ":2: not YAML"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(read, tmp_path, text, kind, message):
    with pytest.raises(kind) as caught:
        read(text)
    assert caught.value.message.startswith(f"{tmp_path}/out.yaml{message}")
