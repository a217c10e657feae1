"""rosbag2_py: bags as programs of ROS 2 read and write them."""

import gc

import pytest
import rosbag2_py
from rclpy.serialization import deserialize_message, serialize_message
from rosbag2_py._storage import QoS
from std_msgs.msg import String

CDR = rosbag2_py.ConverterOptions("cdr", "cdr")


def topic(name, **more):
    return rosbag2_py.TopicMetadata(
        id=0, name=name, type="std_msgs/msg/String", serialization_format="cdr", **more
    )


@pytest.fixture(params=["mcap", "sqlite3"])
def options(tmp_path, request):
    """Options of a bag with ten messages on each of two topics, two at each time."""
    options = rosbag2_py.StorageOptions(uri=tmp_path / "bag", storage_id=request.param)
    writer = rosbag2_py.SequentialWriter()
    writer.open(options, CDR)
    writer.create_topic(topic("/chatter", offered_qos_profiles=[QoS(5).transient_local()]))
    writer.create_topic(topic("/other"))
    for number in range(10):
        writer.write("/chatter", serialize_message(String(data=f"hello {number}")), number * 100)
        writer.write("/other", serialize_message(String(data=f"other {number}")), number * 100)
    # Programs end the bag with the writer.
    del writer
    gc.collect()
    return options


@pytest.fixture
def reader(options):
    reader = rosbag2_py.SequentialReader()
    reader.open(options, CDR)
    yield reader
    reader.close()


def words(reader):
    """Read to the end."""
    found = []
    while reader.has_next():
        _, data, _ = reader.read_next()
        found.append(deserialize_message(data, String).data)
    return found


def test_messages_come_back_in_their_order_with_topic_and_time(reader):
    assert reader.read_next()[0] == "/chatter"
    name, data, time_ns = reader.read_next()
    assert (name, deserialize_message(data, String).data, time_ns) == ("/other", "other 0", 0)
    assert len(words(reader)) == 18
    with pytest.raises(RuntimeError, match="No next message"):
        reader.read_next()


def test_a_filter_set_while_reading_goes_on_where_the_reader_is(reader):
    reader.read_next()
    reader.set_filter(rosbag2_py.StorageFilter(topics=["/other"]))
    assert reader.read_next()[:3:2] == ("/other", 0)
    assert reader.read_next()[:3:2] == ("/other", 100)
    reader.reset_filter()
    assert [reader.read_next()[:3:2] for _ in range(2)] == [("/chatter", 200), ("/other", 200)]
    reader.set_filter(rosbag2_py.StorageFilter(regex="/ch.*", exclude_topics=["/other"]))
    assert words(reader) == [f"hello {number}" for number in range(3, 10)]


def test_a_reader_seeks_and_reads_in_reverse(reader):
    reader.seek(850)
    assert words(reader) == ["hello 9", "other 9"]
    assert reader.set_read_order(rosbag2_py.ReadOrder(reverse=True))
    reader.seek(150)
    assert words(reader) == []  # the first seek bounds the bag from below
    assert not reader.set_read_order(rosbag2_py.ReadOrder(rosbag2_py.ReadOrderSortBy.File))


def test_reverse_reading_yields_the_messages_from_the_last_to_the_first(reader):
    forwards = words(reader)
    reader.set_read_order(rosbag2_py.ReadOrder(reverse=True))
    assert words(reader) == forwards[::-1]


def test_metadata_names_topics_counts_times_and_qos(reader, options):
    metadata = reader.get_metadata()
    assert metadata.message_count == 20
    assert metadata.starting_time.nanoseconds == 0
    assert metadata.duration.nanoseconds == 900
    assert metadata.storage_identifier == options.storage_id
    chatter = metadata.topics_with_message_count[0]
    assert (chatter.topic_metadata.name, chatter.message_count) == ("/chatter", 10)
    (qos,) = chatter.topic_metadata.offered_qos_profiles
    profile = rosbag2_py.convert_rclcpp_qos_to_rclpy_qos(qos)
    assert (profile.depth, profile.durability.short_key) == (5, "transient_local")
    (definition,) = reader.get_all_message_definitions()
    assert (definition.encoding, definition.topic_type) == ("ros2msg", "std_msgs/msg/String")
    assert "string data" in definition.encoded_message_definition
    kept = rosbag2_py.MetadataIo()
    assert kept.metadata_file_exists(options.uri)
    assert kept.read_metadata(options.uri).message_count == 20
    again = kept.deserialize_metadata(kept.serialize_metadata(metadata))
    assert again.topics_with_message_count[1].message_count == 10
    assert rosbag2_py.Info().read_metadata(options.uri, "").message_count == 20


def test_a_bag_is_rewritten_and_reindexed(options, tmp_path):
    config = tmp_path / "out.yaml"
    config.write_text(f"output_bags: [{{uri: {tmp_path / 'new'}, topics: [/other]}}]")
    rosbag2_py.bag_rewrite([options], str(config))
    new = rosbag2_py.StorageOptions(uri=str(tmp_path / "new"))
    (tmp_path / "new" / "metadata.yaml").unlink()
    rosbag2_py.Reindexer().reindex(new)
    assert rosbag2_py.Info().read_metadata(new.uri, "").message_count == 10


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda made, _: made.write("/chatter", b"", 0), "not open"),
        (lambda made, uri: made.open(rosbag2_py.StorageOptions(uri=uri), CDR), "already exists"),
        (lambda _, uri: rosbag2_py.StorageOptions(uri=uri, storage_id="rosbag_v2"), "rosbag_v2"),
        (lambda *_: rosbag2_py.ConverterOptions("json", ""), "json"),
        (lambda *_: rosbag2_py.SequentialReader().open_uri("nowhere"), "does not exist"),
        (lambda *_: rosbag2_py.SequentialReader().has_next(), "not open"),
    ],
)
def test_mistakes_are_runtime_errors_as_in_ros_2(tmp_path, call, text):
    with pytest.raises(RuntimeError, match=text):
        call(rosbag2_py.SequentialWriter(), tmp_path)


def test_a_message_needs_a_topic_that_was_created(tmp_path):
    with rosbag2_py.SequentialWriter() as writer:
        writer.open(rosbag2_py.StorageOptions(uri=str(tmp_path / "bag")), CDR)
        with pytest.raises(RuntimeError, match="Call 'create_topic' first"):
            writer.write("/chatter", b"", 0)
