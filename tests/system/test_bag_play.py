"""``teleopctl bag play`` and ``bag burst`` between real processes."""

from __future__ import annotations

import contextlib
import os
import random
import select
import signal
import subprocess
import sys
import threading

import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import StoragePlugin

from teleopctl.bag import BagTopic, BagWriter, TypeText, WriterOptions
from teleopctl.interfaces import get_message, get_service, to_nanoseconds, type_hash as type_hash_of
from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.hashing import type_hash
from teleopctl.node import Context, Node, Parameter, add_type_from_graph, raw_message_class
from teleopctl.testing import eventually
from tests.bag.bags import START_NS, STRING, message, topic, write_bag
from tests.bag.player.listening import Listener, as_received
from tests.bag.test_foreign import write_with_rosbags

MS = 1_000_000
PLAYER = "/rosbag2_player"

_ON_A_TERMINAL = """
import fcntl, os, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.executable, [sys.executable, "-m", "teleopctl", *sys.argv[1:]])
"""


@pytest.fixture
def listener(ros) -> Listener:
    """What comes on the topics of the tests' bags, in this process."""
    listener = Listener(ros.node)
    for name in ("/topic_0", "/topic_1"):
        listener.subscribe(name)
    return listener


def call(ros, name: str, type_name: str, **fields):
    """Ask a service of the player."""
    service = get_service(f"rosbag2_interfaces/srv/{type_name}")
    client = ros.node.create_client(service, f"{PLAYER}/{name}")
    assert client.wait_for_service(20)
    answer = client.call(service.Request(**fields), 20)
    assert answer is not None
    return answer


def said(process):
    """The lines of the player's log, without their heads."""
    lines = process.stderr.splitlines()
    assert all(line.startswith("[INFO] [") for line in lines)
    return [line.partition("] [rosbag2_player]: ")[2] for line in lines]


def at(time_ns: int):
    """A time of a request."""
    seconds, nanoseconds = divmod(time_ns, 10**9)
    return get_message("builtin_interfaces/msg/Time")(sec=seconds, nanosec=nanoseconds)


def test_a_subscriber_gets_every_message_byte_for_byte(ros, listener):
    written = write_bag(ros.folder / "bag", count=1000)
    done = ros.run("bag play bag --rate 5 --disable-keyboard-controls")
    assert (done.stdout, done.returncode) == ("", 0)
    assert said(done) == ["Set rate to 5", "Playback until timestamp: -1"]
    listener.wait_for_count(1000)
    assert listener.received == as_received(written)


@pytest.mark.parametrize("storage", StoragePlugin)
def test_bags_of_rosbags_are_played(ros, storage):
    written = write_with_rosbags(ros.folder / "bag", storage)
    listener = Listener(ros.node)
    listener.subscribe("/x", is_latched=True)
    done = ros.run("bag play bag")
    assert (done.stdout, done.returncode) == ("", 0)
    assert said(done) == [
        "Set rate to 1",
        "Adding keyboard callbacks.",
        "Press SPACE for Pause/Resume",
        "Press CURSOR_RIGHT for Play Next Message",
        "Press CURSOR_UP for Increase Rate 10%",
        "Press CURSOR_DOWN for Decrease Rate 10%",
        "Playback until timestamp: -1",
    ]
    listener.wait_for_count(20)
    assert listener.received == as_received(written)


def test_a_type_that_only_the_bag_knows_is_played_and_explained(ros):
    place, goals = "strange_msgs/msg/Place", "strange_msgs/msg/Goals"
    text = f"string[] names\nPlace where\n{'=' * 80}\nMSG: strange_msgs/Place\nfloat64 x\n"
    catalog = Catalog()
    catalog.add_text(place, "float64 x\n")
    catalog.add_text(goals, "string[] names\nPlace where\n")
    found = catalog.find(goals)
    assert found is not None
    version = type_hash(found, lambda name: catalog.find(name) or pytest.fail(name))
    listener = Listener(ros.node)
    listener.subscribe("/goals", goals, version)
    data = bytes(range(40))
    with BagWriter(ros.folder / "bag", WriterOptions()) as writer:
        writer.add_topic(BagTopic("/goals", goals, "", TypeText("ros2msg", text)))
        writer.write(message("/goals", 0)._replace(data=data))
    playing = ros.spawn("bag play bag --start-paused")
    ros.wait_for_nodes(PLAYER)
    assert call(ros, "play_next", "PlayNext").success
    listener.wait_for_count(1)
    assert listener.received == [("/goals", data)]
    add_type_from_graph(ros.node, goals, ros.node.graph())
    assert get_message(goals)().where.x == 0.0
    playing.interrupt()
    assert playing.wait() == 0


def test_the_services_control_the_player(ros, listener):
    # Long enough that a slow test does not reach its end.
    written = write_bag(ros.folder / "bag", count=4000)
    playing = ros.spawn("bag play bag -p --disable-keyboard-controls")
    ros.wait_for_nodes(PLAYER)
    assert call(ros, "is_paused", "IsPaused").paused
    assert call(ros, "play_next", "PlayNext").success
    assert call(ros, "burst", "Burst", num_messages=4).actually_burst == 4
    assert call(ros, "seek", "Seek", time=at(written[50].log_time_ns)).success
    assert call(ros, "burst", "Burst", num_messages=1).actually_burst == 1
    listener.wait_for_count(6)
    assert listener.received == as_received([*written[:5], written[50]])
    assert not call(ros, "set_rate", "SetRate", rate=0.0).success
    assert call(ros, "set_rate", "SetRate", rate=0.5).success
    assert call(ros, "get_rate", "GetRate").rate == 0.5
    assert not call(ros, "play", "Play").success
    call(ros, "resume", "Resume")
    listener.wait_for_count(8)
    call(ros, "toggle_paused", "TogglePaused")
    assert call(ros, "is_paused", "IsPaused").paused
    call(ros, "pause", "Pause")
    assert not call(ros, "play", "Play").success
    call(ros, "stop", "Stop")
    assert playing.wait() == 0
    for said in ("Set rate to 0.5", "Resuming play.", "Pausing play.", "Stopping playback."):
        assert f"[rosbag2_player]: {said}\n" in playing.stderr


def test_the_keys_of_a_terminal_control_the_player(ros, listener):
    pytest.importorskip("termios")
    written = write_bag(ros.folder / "bag", count=4)
    terminal, theirs = os.openpty()
    # A child of a program with threads must not run Python before its exec: it takes the terminal
    # for its own behind that.
    child = subprocess.Popen(
        [sys.executable, "-c", _ON_A_TERMINAL, *["bag", "play", "bag", "-p", "--loop"]],
        env=ros.env,
        cwd=ros.folder,
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    # When its terminal goes, it ends, whatever became of the test.
    with child, contextlib.closing(_Screen(terminal)) as shown:
        shown.wait_for("Progress bar enabled at 3 Hz.")
        shown.wait_for("Press CURSOR_DOWN for Decrease Rate 10%")
        shown.wait_for("====== Playback Progress ======")
        shown.wait_for(f"[{START_NS // 10**9}.000000000] Duration 0.00/0.00 [P]")
        for number in range(1, 4):
            os.write(terminal, b"\x1b[C")
            listener.wait_for_count(number)
        assert listener.received == as_received(written[:3])
        os.write(terminal, b"\x1b[A")
        shown.wait_for("Set rate to 1.1")
        os.write(terminal, b"\x1b[B\x1b[B")
        shown.wait_for("Set rate to 0.9")
        os.write(terminal, b" ")
        shown.wait_for("Resuming play.")
        listener.wait_for_count(9)
        os.write(terminal, b" ")
        shown.wait_for("Pausing play.")
        os.write(terminal, b"\x03")
        assert child.wait(20) == 0


class _Screen:
    """What a program writes on its terminal."""

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._text = ""

    def close(self) -> None:
        """Let the terminal go."""
        os.close(self._terminal)

    def wait_for(self, part: str) -> None:
        """Read on until a text has been shown behind the last one."""
        while part not in self._text:
            readable, _, _ = select.select([self._terminal], [], [], 20)
            assert readable, self._text
            self._text += os.read(self._terminal, 4096).decode()
        self._text = self._text.partition(part)[2]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_at_once_and_leaves_nothing(ros, listener, number):
    write_bag(ros.folder / "bag", count=100)
    playing = ros.spawn("bag play bag --loop --delay 3600")
    ros.wait_for_nodes(PLAYER)
    playing.wait_for_line("Playback until timestamp: -1")
    os.kill(playing.pid, number)
    assert playing.wait() == 0
    assert "Traceback" not in playing.stderr
    assert ros.node.context.wait_for_graph(lambda graph: not graph.find_node(PLAYER), 20)


def test_a_burst_ends_paused(ros, listener):
    written = write_bag(ros.folder / "bag", count=100)
    playing = ros.spawn("bag burst bag -n 30 --topics /topic_0")
    playing.wait_for_line("Burst 30 messages.")
    listener.wait_for_count(30)
    assert listener.received == as_received(written[:60:2])
    assert call(ros, "is_paused", "IsPaused").paused
    playing.interrupt()
    assert playing.wait() == 0


def test_a_burst_waits_for_a_subscriber_that_reads_nothing(ros):
    """What it sends is more than the sockets between the two have room for."""
    with BagWriter(ros.folder / "bag", WriterOptions()) as writer:
        writer.add_topic(topic("/topic_0"))
        for number in range(2000):
            writer.write(message("/topic_0", number, data=f"{number:20000}"))
    came: list[bytes] = []
    may_read, all_came = threading.Event(), threading.Event()

    def hear(data: bytes) -> None:
        may_read.wait(60)
        came.append(data)
        if len(came) == 2000:
            all_came.set()

    with Context() as context, Node("reader", context=context) as reader:
        reader.create_subscription(
            raw_message_class(STRING, type_hash_of(STRING)),
            "/topic_0",
            hear,
            10,
            raw=True,
            immediate=True,
        )
        playing = ros.spawn("bag burst bag")
        with pytest.raises(AssertionError, match="no line matches"):
            playing.wait_for_line("Burst 2000 messages.", timeout_s=3)
        may_read.set()
        playing.wait_for_line("Burst 2000 messages.")
        assert all_came.wait(20), len(came)
        playing.interrupt()
        assert playing.wait() == 0


def test_damage_is_told_and_what_stands_behind_it_is_played(ros, listener):
    written = write_bag(ros.folder / "bag", count=300, options=WriterOptions(chunk_bytes=2000))
    file = ros.folder / "bag" / "bag_0.mcap"
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    broken = summary.chunk_indexes[3]
    with file.open("r+b") as stream:
        stream.seek(broken.chunk_start_offset + broken.chunk_length // 2)
        stream.write(random.Random(1).randbytes(200))
    done = ros.run("bag play bag --rate 10")
    assert done.returncode == 0
    assert done.stderr.count(f"the chunk at byte {broken.chunk_start_offset} is broken") == 1
    whole = [
        m
        for m in written
        if not broken.message_start_time <= m.log_time_ns <= broken.message_end_time
    ]
    listener.wait_for_count(len(whole))
    assert listener.received == as_received(whole)


def test_a_bag_that_was_cut_off_is_played_with_one_warning(ros, listener):
    written = write_bag(ros.folder / "bag", count=300, options=WriterOptions(chunk_bytes=2000))
    file = ros.folder / "bag" / "bag_0.mcap"
    os.truncate(file, file.stat().st_size // 2)
    done = ros.run("bag play bag --rate 10")
    assert done.returncode == 0
    assert done.stderr.count("was not finished") == 1
    listener.wait_for_count(100)
    assert listener.received == as_received(written[: len(listener.received)])


def test_the_clock_that_is_published_takes_the_place_of_the_bags(ros, listener):
    clock = "rosgraph_msgs/msg/Clock"
    with BagWriter(ros.folder / "bag", WriterOptions()) as writer:
        for name, type_name in (("/clock", clock), ("/topic_0", STRING)):
            writer.add_topic(topic(name, type_name))
        for number in range(0, 60_000, 1000):
            writer.write(message("/clock", number, clock, clock=at(1)))
            writer.write(message("/topic_0", number))
    playing = ros.spawn("bag play bag --clock")
    seen = ros.wait_for_message(get_message(clock), "/clock")
    assert START_NS <= to_nanoseconds(seen.clock) < START_NS + 60 * 10**9
    with Node(
        "simulated",
        context=ros.node.context,
        parameter_overrides=[Parameter("use_sim_time", value=True)],
    ) as follower:
        eventually(lambda: follower.get_clock().now().nanoseconds > START_NS)
        assert follower.get_clock().now().nanoseconds < START_NS + 60 * 10**9
    (publisher,) = ros.node.get_publishers_info_by_topic("/clock")
    assert publisher.node_name == "rosbag2_player"
    playing.interrupt()
    assert playing.wait() == 0


def test_recorded_requests_are_sent_again(ros):
    kind = "example_interfaces/srv/AddTwoInts"
    service = get_service(kind)
    asked: list[tuple[int, int]] = []

    def add(request, response):
        asked.append((request.a, request.b))
        return response

    ros.node.create_service(service, "/add", add)
    events = "/add/_service_event"
    with BagWriter(ros.folder / "bag", WriterOptions()) as writer:
        writer.add_topic(topic(events, f"{kind}_Event"))
        for number, event_type in enumerate((0, 1, 2, 3, 1)):
            info = get_message("service_msgs/msg/ServiceEventInfo")(event_type=event_type)
            request = [service.Request(a=number, b=event_type)] if event_type < 2 else []
            writer.write(message(events, number, f"{kind}_Event", info=info, request=request))
    playing = ros.spawn("bag play bag --publish-service-requests -p")
    ros.wait_for_nodes(PLAYER)
    assert call(ros, "burst", "Burst", num_messages=0).actually_burst == 2
    call(ros, "stop", "Stop")
    assert playing.wait() == 0
    eventually(lambda: asked == [(1, 1), (4, 1)])


def test_a_bag_that_is_not_there_is_told(ros):
    done = ros.run("bag play nowhere")
    assert done.returncode == 1
    assert done.stderr == "teleopctl: Bag path 'nowhere' does not exist!\n"
