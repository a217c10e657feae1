"""The recorder as programs and tests use it, with real nodes."""

import threading
from typing import Any

import pytest

from teleopctl.bag import (
    Recorder,
    RecorderOptions,
    Selection,
    WriterOptions,
    check,
    open_bag,
    read_metadata,
)
from teleopctl.bag.storage.bag_writer import BagWriter
from teleopctl.errors import RefusedError, SystemFailureError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    qos_profile_latched,
    qos_profile_sensor_data,
    raw_message_class,
)
from teleopctl.testing import eventually
from tests.system.recording import (
    String,
    call,
    contents,
    record,
    say,
    select,
    wait_for_count,
    wait_until_written,
)


def test_a_type_that_nobody_explains_is_recorded_without_definition_and_said_once(ros, caplog):
    kind = raw_message_class("nobody_msgs/msg/Thing", "RIHS01_" + "0" * 64)
    with Recorder(ros.folder / "bag", select("/things", "/more")) as recorder:
        for topic in ("/things", "/more"):
            publisher = ros.node.create_publisher(kind, topic, 10)
            assert ros.node.wait_for_subscribers(topic, 1, 20)
            publisher.publish(b"\0\1\0\0abcd")
        wait_for_count(recorder, 2)
    with open_bag(ros.folder / "bag") as bag:
        assert {m.topic: m.data for m in bag.messages()} == {
            "/things": b"\0\1\0\0abcd",
            "/more": b"\0\1\0\0abcd",
        }
        assert {t.definition.text for t, _ in bag.metadata.topics} == {""}


def test_services_are_recorded_by_their_events(ros):
    event = get_message("std_srvs/srv/Trigger_Event")
    options = RecorderOptions(Selection(all_services=True), recording_metadata=False)
    with Recorder(ros.folder / "bag", options) as recorder:
        say(ros, "/chatter", ["not this"], subscribers=0)
        publisher = ros.node.create_publisher(event, "/reset/_service_event", 10)
        assert ros.node.wait_for_subscribers("/reset/_service_event", 1, 20)
        publisher.publish(event())
        wait_for_count(recorder, 1)
        assert recorder.topics == ["/reset/_service_event"]
    # rosbags cannot make anything of a type below srv/.
    with open_bag(ros.folder / "bag") as bag:
        assert [message.topic for message in bag.messages()] == ["/reset/_service_event"]
        ((topic, _),) = bag.metadata.topics
        assert "MSG: service_msgs/ServiceEventInfo" in topic.definition.text


def test_a_later_publisher_is_recorded_whatever_it_offers(ros):
    with Recorder(ros.folder / "bag", select("/chatter")) as recorder:
        say(ros, "/chatter", ["volatile"])
        wait_for_count(recorder, 1)
        say(ros, "/chatter", ["best effort"], qos_profile_sensor_data)
        wait_for_count(recorder, 2)
        latched = ros.node.create_publisher(String, "/chatter", qos_profile_latched)
        latched.publish(String(data="latched"))
        wait_for_count(recorder, 3)
    assert sorted(contents(ros.folder / "bag")["/chatter"]) == [
        "best effort",
        "latched",
        "volatile",
    ]


def test_a_paused_recorder_leaves_out_what_comes_but_for_what_is_latched(ros):
    options = RecorderOptions(
        Selection(topics=["/chatter", "/description"]), recording_metadata=False, start_paused=True
    )
    with Recorder(ros.folder / "bag", options) as recorder:
        assert call(ros, "IsPaused").paused
        say(ros, "/description", ["a robot"], qos_profile_latched)
        publisher = say(ros, "/chatter", ["lost"])
        marks = ros.node.create_publisher(String, "/description", qos_profile_latched)
        marks.publish(String(data="a mark"))
        eventually(lambda: recorder.skipped_count == 3)
        call(ros, "Resume")
        assert not call(ros, "IsPaused").paused
        publisher.publish(String(data="kept"))
        wait_for_count(recorder, 3)
        call(ros, "Pause")
        assert recorder.is_paused
        call(ros, "TogglePaused")
        assert not recorder.is_paused
        assert not recorder.losses
    assert contents(ros.folder / "bag") == {
        "/description": ["a robot", "a mark"],
        "/chatter": ["kept"],
    }
    assert list(check(ros.folder / "bag")) == []


def test_split_begins_a_file_that_has_what_is_latched_and_says_so(ros):
    event = get_message("rosbag2_interfaces/msg/WriteSplitEvent")
    events: list[Any] = []
    ros.node.create_subscription(event, "/events/write_split", events.append, 10)
    with Recorder(ros.folder / "bag", select("/chatter", "/description")) as recorder:
        say(ros, "/description", ["a robot"], qos_profile_latched)
        publisher = say(ros, "/chatter", ["one"])
        wait_for_count(recorder, 2)
        call(ros, "SplitBagfile")
        publisher.publish(String(data="two"))
        wait_for_count(recorder, 3)
        eventually(lambda: events)
    first, second = (ros.folder / "bag" / f"bag_{number}.mcap" for number in (0, 1))
    assert (events[0].closed_file, events[0].opened_file) == (str(first), str(second))
    assert events[0].node_name == "/rosbag2_recorder"
    assert contents(first) == {"/description": ["a robot"], "/chatter": ["one"]}
    assert contents(second) == {"/description": ["a robot"], "/chatter": ["two"]}
    assert list(check(ros.folder / "bag")) == []


def test_only_the_newest_files_are_kept(ros):
    options = RecorderOptions(
        Selection(topics=["/chatter"]), WriterOptions(most_files=2), recording_metadata=False
    )
    with Recorder(ros.folder / "bag", options) as recorder:
        publisher = say(ros, "/chatter", [])
        for number in range(4):
            publisher.publish(String(data=str(number)))
            wait_for_count(recorder, number + 1)
            call(ros, "SplitBagfile")
    metadata = read_metadata(ros.folder / "bag")
    assert [file.path for file in metadata.files] == ["bag_3.mcap", "bag_4.mcap"]
    assert [count for _, count in metadata.topics] == [1]
    assert contents(ros.folder / "bag") == {"/chatter": ["3"]}


def test_a_snapshot_is_written_when_it_is_asked_for(ros):
    options = RecorderOptions(
        Selection(topics=["/chatter"]), snapshot=True, recording_metadata=False, cache_bytes=250
    )
    with Recorder(ros.folder / "bag", options) as recorder:
        publisher = ros.node.create_publisher(String, "/chatter", 10)
        assert ros.node.wait_for_subscribers("/chatter", 1, 20)
        for number in range(20):
            publisher.publish(String(data=f"{number:80d}"))
            wait_for_count(recorder, number + 1)
            # What waits is bounded as well: let it go into the memory first.
            recorder.flush()
            if number in (9, 19):
                assert call(ros, "Snapshot").success
    there = [f"{number:80d}" for number in (8, 9, 18, 19)]
    assert contents(ros.folder / "bag") == {"/chatter": there}
    # What fell out of the memory is not lost.
    assert list(check(ros.folder / "bag")) == []


def test_without_snapshot_mode_there_is_no_service_for_it(ros):
    with Recorder(ros.folder / "bag", select("/chatter")):
        assert call(ros, "IsDiscoveryRunning").running
        assert not ros.node.graph().servers("/rosbag2_recorder/snapshot")


def test_stop_ends_a_bag_and_record_begins_another_one(ros):
    with Recorder(ros.folder / "one", select("/chatter")) as recorder:
        publisher = say(ros, "/chatter", ["one"])
        wait_for_count(recorder, 1)
        assert call(ros, "Record", uri="").return_code == 1
        call(ros, "Stop")
        assert not recorder.is_recording
        assert call(ros, "StartDiscovery").error_string == "Recorder is not currently recording."
        answer = call(ros, "Record", uri=str(ros.folder / "two"))
        assert (answer.return_code, answer.error_string) == (0, "")
        assert ros.node.wait_for_subscribers("/chatter", 1, 20)
        publisher.publish(String(data="two"))
        wait_for_count(recorder, 1)
        assert call(ros, "StopDiscovery").return_code == 0
        assert not call(ros, "IsDiscoveryRunning").running
    assert contents(ros.folder / "one") == {"/chatter": ["one"]}
    assert contents(ros.folder / "two") == {"/chatter": ["two"]}


def test_what_finds_no_room_is_counted_by_topic_and_told(ros, monkeypatch):
    disk = threading.Event()
    write = BagWriter.write

    def slow(writer, message):
        disk.wait(20)
        write(writer, message)

    monkeypatch.setattr(BagWriter, "write", slow)
    lost: list[Any] = []
    ros.node.create_subscription(
        get_message("rosbag2_interfaces/msg/MessagesLostEvent"),
        "/events/rosbag2_messages_lost",
        lost.append,
        10,
    )
    selection = Selection(topics=["/chatter"])
    options = RecorderOptions(selection, recording_metadata=False, cache_bytes=100)
    with Recorder(ros.folder / "bag", options) as recorder:
        say(ros, "/chatter", ["x" * 60] * 5)
        eventually(lambda: recorder.losses.in_recorder == {"/chatter": 4})
        eventually(lambda: lost)
        disk.set()
    assert recorder.losses.in_recorder == {"/chatter": 4}
    statistics = [each for event in lost for each in event.messages_lost_statistics]
    assert sum(each.messages_lost_in_recorder for each in statistics) == 4
    assert contents(ros.folder / "bag") == {"/chatter": ["x" * 60]}


def test_what_never_came_is_counted_by_the_numbers_of_the_messages(ros):
    with Recorder(ros.folder / "bag", select("/chatter")) as recorder:
        publishers = [ros.node.create_publisher(String, "/chatter", 10) for _ in range(6)]
        assert ros.node.wait_for_subscribers("/chatter", 1, 20)
        # Each has a count of its own, as the nodes that share /rosout.
        for number, publisher in enumerate(publishers):
            for _ in range(7 * number):
                next(publisher._sequence)
            for text in ("one", "two"):
                publisher.publish(String(data=text))
        for _ in range(3):
            next(publishers[0]._sequence)
        publishers[0].publish(String(data="six"))
        wait_for_count(recorder, 13)
        assert recorder.losses.in_transport == {"/chatter": 3}
    (finding,) = check(ros.folder / "bag")
    assert finding.what.startswith("3 messages were sent and are missing, by the recorder's count")


def test_simulated_time_is_waited_for_and_stands_in_the_bag(ros):
    clock_type = get_message("rosgraph_msgs/msg/Clock")
    options = RecorderOptions(
        Selection(topics=["/chatter"]), use_sim_time=True, recording_metadata=False
    )
    with Recorder(ros.folder / "bag", options) as recorder:
        publisher = ros.node.create_publisher(String, "/chatter", 10)
        clock = ros.node.create_publisher(clock_type, "/clock", 10)
        assert ros.node.wait_for_subscribers("/clock", 1, 20)
        assert recorder.topics == []
        time = clock_type()
        time.clock.sec = 7
        clock.publish(time)
        assert ros.node.wait_for_subscribers("/chatter", 1, 20)
        publisher.publish(String(data="x"))
        wait_for_count(recorder, 1)
    with open_bag(ros.folder / "bag") as bag:
        (message,) = bag.messages()
    assert (message.log_time_ns, message.publish_time_ns) == (7_000_000_000, 7_000_000_000)


def test_the_bag_holds_what_is_needed_to_understand_it(ros, monkeypatch, tmp_path):
    launch = tmp_path / "arm.launch.py"
    launch.write_text("# a launch file")
    monkeypatch.setenv(
        "TELEOPCTL_LAUNCH_OF_RECORDING",
        f'{{"file": "{launch.as_posix()}", "arguments": {{"sim": "true"}}}}',
    )
    ros.node.declare_parameter("gain.p", 2.5)
    description = ros.node.create_publisher(String, "/robot_description", qos_profile_latched)
    description.publish(String(data="<robot/>"))
    options = RecorderOptions(Selection(topics=["/chatter"]))
    wanted = {"robot_description.urdf", "parameters.yaml", "launch/arm.launch.py"}
    with Recorder(ros.folder / "bag", options):
        eventually(lambda: wanted <= _attached(ros.folder / "bag"))
    with open_bag(ros.folder / "bag") as bag:
        attached = {attachment.name: attachment.data.decode() for attachment in bag.attachments()}
        records = dict(bag.records())
    assert attached["robot_description.urdf"] == "<robot/>"
    assert attached["launch/arm.launch.py"] == "# a launch file"
    name = ros.node.get_fully_qualified_name()
    assert f"{name}:\n  ros__parameters:\n    gain:\n      p: 2.5\n" in attached["parameters.yaml"]
    assert records["teleopctl"]["python"]
    assert records["teleopctl.launch"] == {"file": str(launch), "argument.sim": "true"}


def test_a_recording_that_ends_at_once_has_what_was_known(ros):
    ros.node.declare_parameter("gain", 2.5)
    description = ros.node.create_publisher(String, "/robot_description", qos_profile_latched)
    description.publish(String(data="<robot/>"))
    with Recorder(ros.folder / "bag", RecorderOptions(Selection(topics=["/chatter"]))):
        pass
    with open_bag(ros.folder / "bag") as bag:
        attached = {attachment.name: attachment.data.decode() for attachment in bag.attachments()}
        assert dict(bag.records())["teleopctl"]["python"]
    assert attached["robot_description.urdf"] == "<robot/>"
    assert "gain: 2.5" in attached["parameters.yaml"]


def test_a_killed_recording_has_the_parameters_though_the_graph_never_rested(ros):
    ros.node.declare_parameter("gain", 2.5)
    process = record(ros, "-o", "bag", "--topics", "/chatter")

    def is_written(name):
        ros.node.destroy_publisher(ros.node.create_publisher(String, "/restless", 10))
        return name in _attached(ros.folder / "bag")

    eventually(lambda: is_written("parameters.yaml"))
    ros.spawn("run teleop_robot_py_pkg simple_parameter")
    eventually(lambda: is_written("parameters_2.yaml"))
    process.kill()
    with open_bag(ros.folder / "bag") as bag:
        attached = {attachment.name: attachment.data.decode() for attachment in bag.attachments()}
    assert "gain: 2.5" in attached["parameters.yaml"]
    assert attached["parameters_2.yaml"].startswith("/simple_parameter:")


def _attached(folder):
    with open_bag(folder) as bag:
        return {attachment.name for attachment in bag.attachments()}


def test_a_full_disk_ends_it_with_an_error_and_a_bag_that_can_be_read(ros, monkeypatch):
    with (
        pytest.raises(SystemFailureError, match="No space left on device"),
        Recorder(ros.folder / "bag", select("/chatter")) as recorder,
    ):
        publisher = say(ros, "/chatter", ["there"])
        wait_until_written(ros.folder / "bag", 1)

        def full(*_):
            raise SystemFailureError("Cannot write: No space left on device")

        monkeypatch.setattr("teleopctl.bag.mcap_file.file_writer.McapFileWriter.write", full)
        publisher.publish(String(data="lost"))
        assert recorder.wait(20)
    monkeypatch.undo()
    with open_bag(ros.folder / "bag") as bag:
        assert len(list(bag.messages())) == 1


def test_a_recorder_refuses_a_folder_that_is_there(ros):
    (ros.folder / "bag").mkdir()
    with pytest.raises(RefusedError, match="already exists"):
        Recorder(ros.folder / "bag", select("/chatter"))
    assert "/rosbag2_recorder" not in ros.node.get_fully_qualified_node_names()
