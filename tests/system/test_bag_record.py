"""``teleopctl bag record`` with real nodes."""

import os
import signal
import subprocess
import sys

import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from teleopctl.bag import (
    finish_file,
    open_bag,
    read_metadata,
)
from teleopctl.bag.records import ROS2MSG
from teleopctl.interfaces import get_message
from teleopctl.node import Node, qos_profile_latched
from teleopctl.testing import eventually
from tests.samples import sample
from tests.system.recording import (
    PATIENT,
    String,
    call,
    contents,
    record,
    say,
    stop,
    wait_until_written,
    written_count,
)

_ON_A_TERMINAL = """
import fcntl, os, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.executable, [sys.executable, "-m", "teleopctl", *sys.argv[1:]])
"""


def test_record_writes_every_message_as_it_came_and_other_readers_agree(ros):
    latched = ros.node.create_publisher(String, "/description", qos_profile_latched)
    latched.publish(String(data="a robot"))
    early = ros.node.create_publisher(String, "/early", PATIENT)
    process = record(ros, "-o", "bag", "--all", "--exclude-regex", "rosout|events")
    assert ros.node.wait_for_subscribers("/early", 1, 20)
    texts = [f"number {number}" for number in range(200)]
    for text in texts:
        early.publish(String(data=text))
    say(ros, "/late", texts[:50])
    folder = ros.folder / "bag"
    wait_until_written(folder, 251)
    stop(process)
    expected = {"/description": ["a robot"], "/early": texts, "/late": texts[:50]}
    assert contents(folder) == expected
    with (folder / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        decoded: dict[str, list[str]] = {}
        for schema, channel, message, ros_message in reader.iter_decoded_messages():
            assert schema is not None
            assert schema.encoding == ROS2MSG
            assert message.publish_time <= message.log_time
            decoded.setdefault(channel.topic, []).append(ros_message.data)
    assert decoded == expected
    with open_bag(folder) as bag:
        topics = {topic.name: (topic, count) for topic, count in bag.metadata.topics}
        assert topics["/description"][0].is_latched
        assert not topics["/early"][0].is_latched
        assert topics["/early"][1] == 200
        assert bag.metadata.distribution == "jazzy"
        numbers = [message.sequence for message in bag.messages({"/early"})]
        assert numbers == list(range(numbers[0], numbers[0] + 200))


def test_record_says_what_ros2_bag_says(ros):
    say(ros, "/chatter", [], subscribers=0)
    process = record(ros, "-o", "bag", "--topics", "/chatter")
    assert ros.node.wait_for_subscribers("/chatter", 1, 20)
    stop(process)
    lines = [line.partition("]: ")[2] for line in process.stderr.splitlines()]
    # What is there at the start may be heard of at once or a moment later.
    lines.remove("Subscribed to topic '/chatter'")
    assert lines == [
        "Starting recording to 'bag'",
        "Topics discovery started.",
        "Listening for topics...",
        "Recording...",
        "Topics discovery stopped.",
        "Recording stopped",
    ]
    assert process.stdout == ""


def test_static_topics_are_recorded_before_anybody_publishes_them(ros):
    (ros.folder / "static.yaml").write_text(
        "static_topics_and_types_list:\n"
        "  - [/later, std_msgs/msg/String]\n"
        "  - [/strange, nobody_msgs/msg/Thing]\n"
    )
    process = record(ros, "-o", "bag", "--static-topics-path", "static.yaml")
    eventually(lambda: ros.node.graph().subscriptions("/later"))
    (subscription,) = ros.node.graph().subscriptions("/later")
    assert subscription.type_name == "std_msgs/msg/String"
    say(ros, "/later", ["one", "two"])
    wait_until_written(ros.folder / "bag", 2)
    stop(process)
    lines = [line.partition("]: ")[2] for line in process.stderr.splitlines()]
    assert lines == [
        "Reading static topics from static.yaml",
        "Read 2 static topics",
        "Starting recording to 'bag'",
        "Subscribed to topic '/later'",
        "'nobody_msgs/msg/Thing' is not known here: '/strange' is recorded from when a node shows "
        "it",
        "Topics discovery started.",
        "Listening for topics...",
        "Recording...",
        "Topics discovery stopped.",
        "Recording stopped",
    ]
    assert contents(ros.folder / "bag") == {"/later": ["one", "two"]}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("-o bag", "Need to specify at least one option out of --all"),
        ("--topics /x --exclude-topics /y", "--exclude-topics argument requires either --all"),
        ("-a --use-sim-time --no-discovery", "--use-sim-time and --no-discovery both set"),
        ("-a -o there", "Output folder 'there' already exists."),
        ("-a --compression-format zstd", "Cannot specify compression format"),
        ("-a --max-bag-files 3", "--max-bag-files requires --max-bag-size"),
    ],
)
def test_what_ros2_bag_refuses_is_refused_in_its_words(ros_without_router, options, message):
    ros = ros_without_router
    (ros.folder / "there").mkdir()
    done = ros.run(f"bag record {options}")
    assert message in done.stderr
    assert done.returncode == 1


def test_what_there_is_not_is_said_plainly(ros_without_router):
    done = ros_without_router.run("bag record -a -s sqlite3 --compression-mode file")
    assert "Databases are written as they are, and not compressed" in done.stderr
    assert done.returncode == 2


def test_types_that_are_not_known_here_are_recorded_with_their_definition(ros, start_stranger):
    start_stranger()
    process = record(ros, "-o", "bag", "--topics", "/goals")
    reader = ros.folder / "bag"
    ros.node.wait_for_subscribers("/goals", 1, 20)
    eventually(lambda: call(ros, "SplitBagfile") and _message_count(reader) > 0)
    stop(process)
    places = contents(reader)["/goals"]
    assert (places[0].names, places[0].where.x) == (["here", "there"], 2.5)


def _message_count(folder):
    return sum(file.message_count for file in read_metadata(folder).files)


def test_a_topic_with_two_types_is_left_out(ros):
    ros.node.create_publisher(String, "/mixed", 10)
    ros.node.create_publisher(get_message("std_msgs/msg/Int32"), "/mixed", 10)
    process = record(ros, "-o", "bag", "--topics", "/mixed", "/chatter")
    say(ros, "/chatter", ["x"])
    wait_until_written(ros.folder / "bag", 1)
    stop(process)
    text = "Topic '/mixed' has more than one type associated. Only topics with one type"
    assert process.stderr.count(text) == 1
    assert list(contents(ros.folder / "bag")) == ["/chatter"]


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signals")
def test_sigterm_and_a_hung_up_terminal_finish_the_bag(ros):
    for number, name in ((signal.SIGTERM, "term"), (signal.SIGHUP, "hup")):
        process = record(ros, "-o", name, "--topics", f"/{name}")
        say(ros, f"/{name}", ["x"])
        wait_until_written(ros.folder / name, 1)
        os.kill(process.pid, number)
        assert process.wait() == 0, process.report()
        assert contents(ros.folder / name) == {f"/{name}": ["x"]}


def test_the_space_bar_pauses_and_the_terminal_is_put_back(ros):
    termios = pytest.importorskip("termios")
    terminal, theirs = os.openpty()
    before = termios.tcgetattr(theirs)
    log = ros.folder / "said"
    with log.open("w") as written:
        # A child of a program with threads must not run Python before its exec.
        child = subprocess.Popen(
            [sys.executable, "-c", _ON_A_TERMINAL, "bag", "record", "-o", "bag", "-a"],
            env=ros.env,
            cwd=ros.folder,
            stdin=theirs,
            stderr=written,
            start_new_session=True,
        )
    try:
        eventually(lambda: "Recording..." in log.read_text())
        os.write(terminal, b" ")
        eventually(lambda: "Pausing recording." in log.read_text())
        os.write(terminal, b" ")
        eventually(lambda: "Resuming recording." in log.read_text())
        os.write(terminal, b"\x03")
        assert child.wait(20) == 0
        assert "Press SPACE for pausing/resuming" in log.read_text()
        assert termios.tcgetattr(theirs) == before
    finally:
        child.kill()
        child.wait()
        os.close(terminal)
        os.close(theirs)


@pytest.mark.parametrize("waits", [False, True], ids=["at once", "when the others have answered"])
def test_a_node_that_does_not_answer_is_named_and_keeps_no_other_out_of_the_bag(ros, waits):
    answering = ros.node.get_fully_qualified_name()
    # Nobody spins it.
    with Node("silent", context=ros.node.context):
        process = record(ros, "-o", "bag", "-a")
        if waits:
            eventually(lambda: answering in nodes_with_parameters(ros.folder / "bag"))
        stop(process)
    assert "Traceback" not in process.stderr
    lacking = [line for line in process.stderr.splitlines() if "The bag lacks" in line]
    assert len(lacking) == 1
    assert lacking[0].endswith("/silent: no answer") or not waits
    with open_bag(ros.folder / "bag") as bag:
        assert "teleopctl" in dict(bag.records())


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="Windows freezes no processes")
def test_a_recorder_ends_beside_a_frozen_node(ros):
    talker = ros.spawn("run demo_nodes_py talker")
    process = record(ros, "-o", "bag", "-a")
    eventually(lambda: "/talker" in nodes_with_parameters(ros.folder / "bag"))
    os.kill(talker.pid, signal.SIGSTOP)
    try:
        stop(process)
    finally:
        os.kill(talker.pid, signal.SIGCONT)
    assert "Traceback" not in process.stderr
    with open_bag(ros.folder / "bag") as bag:
        assert bag.remarks == []


_ON_A_SMALL_DISK = """
import os, resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, 40_000))
os.execv(sys.executable, [sys.executable, "-m", "teleopctl", *sys.argv[1:]])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows knows no bound on files")
def test_a_full_disk_is_told_in_one_line_and_leaves_what_was_written(ros):
    # A bound on files does what a full disk does.
    words = ["bag", "record", "-o", "bag", "--topics", "/noise"]
    process = ros.spawn_command([sys.executable, "-c", _ON_A_SMALL_DISK, *words])
    publisher = say(ros, "/noise", ["x"] * 6)
    wait_until_written(ros.folder / "bag", 6)
    while publisher.get_subscription_count():
        publisher.publish(String(data=os.urandom(500).hex()))
    assert process.wait() == 1
    lines = [line for line in process.stderr.splitlines() if "[INFO]" not in line]
    assert lines == ["teleopctl: Cannot write bag/bag_0.mcap: File too large"]
    with open_bag(ros.folder / "bag") as bag:
        assert len(list(bag.messages())) >= 6
    assert not (ros.folder / "bag" / "metadata.yaml.part").exists()


def nodes_with_parameters(folder):
    with open_bag(folder) as bag:
        return {
            node
            for each in bag.attachments()
            if each.name.startswith("parameters")
            for node in yaml.safe_load(each.data)
        }


@pytest.mark.parametrize("attempt", sample(range(3), 3))
def test_a_killed_recorder_leaves_all_but_its_last_second(ros, attempt):
    process = record(ros, "-o", "bag", "--topics", "/chatter")
    publisher = ros.node.create_publisher(String, "/chatter", PATIENT)
    assert ros.node.wait_for_subscribers("/chatter", 1, 20)
    file = ros.folder / "bag" / "bag_0.mcap"
    sent = 0

    # Killed while it writes: once some messages stand in the file.
    while sent % 100 or written_count(ros.folder / "bag") <= 100 * attempt:
        publisher.publish(String(data=str(sent)))
        sent += 1
    process.kill()
    with open_bag(ros.folder / "bag") as bag:
        count = len(list(bag.messages()))
    assert count
    finish_file(file)
    assert contents(file) == {"/chatter": [str(number) for number in range(count)]}


@pytest.mark.nightly
def test_a_killed_recorder_of_a_database_leaves_all_but_its_last_second(ros):
    process = record(ros, "-o", "bag", "-s", "sqlite3", "--topics", "/chatter")
    publisher = ros.node.create_publisher(String, "/chatter", PATIENT)
    assert ros.node.wait_for_subscribers("/chatter", 1, 20)
    sent = 0
    while sent % 100 or not written_count(ros.folder / "bag"):
        publisher.publish(String(data=str(sent)))
        sent += 1
    process.kill()
    count = written_count(ros.folder / "bag")
    done = ros.run("bag recover bag")
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(ros.folder / "bag") == {"/chatter": [str(number) for number in range(count)]}
    done = ros.run("bag convert -i bag -o again -s sqlite3")
    assert done.stdout == f"again: {count} messages\n"
    assert contents(ros.folder / "again") == contents(ros.folder / "bag")


def test_qos_overrides_are_taken_from_a_file(ros):
    (ros.folder / "qos.yaml").write_text(
        "/chatter: {reliability: best_effort, history: keep_last, depth: 7}\n"
    )
    ros.node.create_publisher(String, "/chatter", 10)
    process = record(
        ros, "-o", "bag", "--topics", "/chatter", "--qos-profile-overrides-path", "qos.yaml"
    )
    eventually(lambda: ros.node.graph().subscriptions("/chatter"))
    (subscription,) = ros.node.graph().subscriptions("/chatter")
    assert (subscription.qos.reliability, subscription.qos.depth) == (2, 7)
    stop(process)
    assert "Overriding subscription profile for /chatter" in process.stderr


def test_a_wrong_override_is_refused_with_its_topic(ros_without_router):
    ros = ros_without_router
    (ros.folder / "qos.yaml").write_text("/chatter: {reliability: sure}\n")
    done = ros.run("bag record -a --qos-profile-overrides-path qos.yaml")
    assert "qos.yaml: /chatter: 'sure' is no ReliabilityPolicy" in done.stderr
    assert done.returncode == 1
