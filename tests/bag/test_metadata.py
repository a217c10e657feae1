"""``metadata.yaml`` says what a bag holds, in every version that rosbag2 has written."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given, strategies as st
from rosbags.rosbag2.metadata import parse_qos

from teleopctl.bag import BagFile, BagMetadata, BagTopic, TypeText, format_metadata
from teleopctl.bag.metadata import parse_metadata
from teleopctl.bag.qos_profiles import format_offered_profiles, parse_offered_profiles
from teleopctl.errors import InvalidFileError
from teleopctl.wire import INFINITE_NS, EndpointQos

durations = st.one_of(st.just(INFINITE_NS), st.integers(1, 10**15))
profiles = st.builds(
    EndpointQos,
    st.integers(0, 3),
    st.integers(0, 3),
    st.integers(0, 2),
    st.integers(0, 10_000),
    durations,
    durations,
    st.sampled_from([0, 1, 3]),
    durations,
)
names = st.text(st.characters(codec="utf-8", categories=["L", "N"]), min_size=1, max_size=9)
topics = st.builds(
    BagTopic,
    names,
    names,
    names,
    st.just(TypeText()),
    st.lists(profiles, max_size=3, unique=True).map(tuple),
    st.just("cdr"),
    st.just(value=False),
)
files = st.builds(BagFile, names, st.integers(0, 2**60), st.integers(0, 2**60), st.integers(1, 9))


@given(st.lists(profiles, max_size=3, unique=True))
def test_profiles_are_read_as_written_by_us_and_by_rosbags(offers):
    text = format_offered_profiles(offers)
    assert parse_offered_profiles(text) == tuple(offers)
    assert len(parse_qos(text)) == len(offers)


def test_profiles_of_version_9_are_a_list_with_names():
    nine = [
        {
            "history": "keep_last",
            "depth": 1,
            "reliability": "reliable",
            "durability": "transient_local",
            "deadline": {"sec": 9223372036, "nsec": 854775807},
            "lifespan": {"sec": 1, "nsec": 5},
            "liveliness": "automatic",
            "liveliness_lease_duration": {"sec": 9223372036, "nsec": 854775807},
            "avoid_ros_namespace_conventions": False,
        }
    ]
    expected = EndpointQos(durability=1, depth=1, lifespan_ns=1_000_000_005)
    assert parse_offered_profiles(nine) == (expected,)
    assert parse_offered_profiles(yaml.safe_dump(nine)) == (expected,)


@pytest.mark.parametrize(
    ("seconds", "nanoseconds"),
    [(9223372036, 854775807), (2**31 - 1, 2**32 - 1), (2**31 - 1, 2**31 - 1), (0, 0), (-1, 0)],
)
def test_every_infinite_duration_of_rosbag2_is_infinite(seconds, nanoseconds):
    value = [{"deadline": {"sec": seconds, "nsec": nanoseconds}}]
    assert parse_offered_profiles(value) == (EndpointQos(deadline_ns=INFINITE_NS),)


@pytest.mark.parametrize("value", ["[", "word", [1], [{"deadline": {"sec": 1}}]])
def test_what_is_no_profile_is_told(value):
    with pytest.raises(InvalidFileError, match="offered_qos_profiles"):
        parse_offered_profiles(value)


@given(
    st.builds(
        BagMetadata,
        st.lists(files, min_size=1, max_size=3, unique_by=lambda f: f.path).map(tuple),
        st.lists(st.tuples(topics, st.integers(0, 2**40)), max_size=3).map(tuple),
        custom_data=st.dictionaries(names, names, max_size=2),
        distribution=names,
    )
)
def test_metadata_is_read_as_written(metadata):
    assert parse_metadata(format_metadata(metadata)) == metadata


def test_texts_that_look_like_numbers_stay_texts():
    metadata = BagMetadata(custom_data={"speed": "1e5", "day": "2026-11-22"}, distribution="0E0")
    assert parse_metadata(format_metadata(metadata)) == metadata


def test_a_bag_of_foxy_has_no_files_listed_and_its_folder_in_the_paths():
    old = """
rosbag2_bagfile_information:
  version: 4
  storage_identifier: sqlite3
  relative_file_paths: [walk/walk_0.db3]
  duration: {nanoseconds: 5}
  starting_time: {nanoseconds_since_epoch: 7}
  message_count: 2
  topics_with_message_count:
    - topic_metadata:
        {name: /x, type: std_msgs/msg/String, serialization_format: cdr, offered_qos_profiles: ""}
      message_count: 2
  compression_format: ""
  compression_mode: NONE
"""
    metadata = parse_metadata(old)
    assert metadata.files == (BagFile("walk_0.db3", 7, 5, 2),)
    assert metadata.topics == ((BagTopic("/x", "std_msgs/msg/String"), 2),)
    assert (metadata.storage, metadata.compression_mode) == ("sqlite3", "")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[", "not YAML"),
        ("a: 1", "no rosbag2_bagfile_information"),
        ("rosbag2_bagfile_information: {version: 10}", "version 10"),
        ("rosbag2_bagfile_information: {version: 8}", "'relative_file_paths' is missing"),
        (
            "rosbag2_bagfile_information: {version: 8, relative_file_paths: 3}",
            "value is of the wrong kind",
        ),
    ],
)
def test_a_text_that_is_no_metadata_is_told(text, why):
    with pytest.raises(InvalidFileError, match=why):
        parse_metadata(text)


@given(st.text(max_size=200))
def test_no_text_raises_anything_else(text):
    with pytest.raises(InvalidFileError):
        parse_metadata(text)
