"""The player sends what it is to send, once and in order, whatever it is told meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import pytest

from teleopctl.bag import BagMessage, BagWriter, Player, PlayOptions, PlaySelection, WriterOptions
from teleopctl.errors import InvalidFileError, NotFoundError, UsageError
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import Context, Node, QoSProfile
from tests.bag.bags import LATCHED, START_NS, STRING, message, topic, write_bag
from tests.bag.player.listening import Listener, as_received

MS = 1_000_000
FAST = PlayOptions(rate=1000.0)
PAUSED = PlayOptions(is_paused=True)


@pytest.fixture
def node(shared_ros) -> Iterator[Node]:
    """A node of the test's own that plays, in a graph that the module's tests share."""
    context = Context()
    context.init([])
    try:
        with Node("player", context=context) as node:
            yield node
    finally:
        context.try_shutdown()


@pytest.fixture
def listener(node) -> Listener:
    """What comes on both topics of the tests' bags."""
    listener = Listener(node)
    for number in range(2):
        listener.subscribe(f"/topic_{number}")
    return listener


def play(node: Node, bag, options: PlayOptions = FAST) -> None:
    """Play to the end."""
    with Player(node, bag, options) as player:
        assert player.play()
        assert player.wait(60)


def test_every_message_is_sent_once_and_in_order(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=500)
    play(node, tmp_path / "bag")
    assert listener.received == as_received(written)


def test_a_queue_of_one_message_is_enough(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=200)
    play(node, tmp_path / "bag", replace(FAST, read_ahead=1))
    assert listener.received == as_received(written)


@pytest.mark.parametrize(
    ("options", "first", "last"),
    [
        ({"start_offset_ns": 30 * MS}, 30, 99),
        ({"duration_ns": 10 * MS}, 0, 10),
        ({"start_offset_ns": 30 * MS, "duration_ns": 10 * MS}, 30, 40),
        ({"until_ns": START_NS + 5 * MS}, 0, 5),
        ({"until_ns": START_NS + 5 * MS, "duration_ns": 20 * MS}, 0, 20),
        ({"duration_ns": 0}, 0, -1),
        ({"start_offset_ns": 1000 * MS}, 0, -1),
    ],
)
def test_a_part_is_played(node, listener, tmp_path, options, first, last):
    written = write_bag(tmp_path / "bag", count=100)
    play(node, tmp_path / "bag", replace(FAST, **options))
    assert listener.received == as_received(written[first : last + 1])


@pytest.mark.parametrize(
    "selection",
    [
        PlaySelection(topics=("topic_1",)),
        PlaySelection(exclude_topics=("/topic_0",)),
        PlaySelection(regex="/.*_1"),
        PlaySelection(exclude_regex=".*0"),
        PlaySelection(topics=("/topic_1", "/other"), exclude_topics=("/other",)),
        PlaySelection(regex="/topic_.", exclude_regex="/topic_0"),
    ],
)
def test_topics_are_selected(node, listener, tmp_path, selection):
    written = write_bag(tmp_path / "bag", count=20)
    play(node, tmp_path / "bag", replace(FAST, selection=selection))
    assert listener.received == as_received([m for m in written if m.topic == "/topic_1"])


def test_remapped_topics_come_under_their_other_names(shared_ros, tmp_path):
    written = write_bag(tmp_path / "bag", count=20, topics=1)
    context = Context()
    context.init(["--ros-args", "-r", "/topic_0:=/elsewhere"])
    with Node("player", context=context) as node:
        listener = Listener(node)
        listener.subscribe("/elsewhere")
        play(node, tmp_path / "bag")
        assert listener.received == [("/elsewhere", m.data) for m in written]
    context.try_shutdown()


def test_a_loop_begins_anew_until_it_is_stopped(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=10)
    with Player(node, tmp_path / "bag", replace(FAST, loop=True)) as player:
        player.play()
        listener.wait_for_count(35)
        assert player.stop()
        assert player.wait(0)
    expected = as_received(written) * (len(listener.received) // 10 + 1)
    assert listener.received == expected[: len(listener.received)]


def test_a_loop_over_nothing_ends(node, tmp_path):
    write_bag(tmp_path / "bag", count=0)
    play(node, tmp_path / "bag", replace(FAST, loop=True))


def test_while_paused_messages_come_one_by_one(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=4)
    with Player(node, tmp_path / "bag", PAUSED) as player:
        assert not player.play_next()  # it does not play yet
        player.play()
        for number in range(1, 5):
            assert player.play_next()
            assert listener.received == as_received(written[:number])
            assert player.position_ns == written[number - 1].log_time_ns
        assert not player.play_next()  # nothing is left
        player.resume()
        assert player.wait(20)
    assert listener.received == as_received(written)


def test_a_burst_sends_so_many_at_once_and_stays_paused(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=2000)
    with Player(node, tmp_path / "bag", PAUSED) as player:
        player.play()
        assert player.burst(1500) == 1500
        assert player.is_paused
        assert listener.received == as_received(written[:1500])
        assert player.burst() == 500
        player.resume()
        assert not player.burst(1)
    assert listener.received == as_received(written)


def test_a_seek_goes_on_from_there_and_back_again(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=100, options=WriterOptions(chunk_bytes=300))
    with Player(node, tmp_path / "bag", PAUSED) as player:
        assert not player.seek(START_NS)
        player.play()
        player.burst(10)
        assert player.seek(written[60].log_time_ns)
        player.burst(2)
        assert player.seek(0)
        player.burst(1)
        player.seek(written[98].log_time_ns - 1)
        player.burst()
        player.seek(START_NS + 10**15)
        assert player.burst() == 0
        player.seek(written[99].log_time_ns)
        player.resume()
        assert player.wait(20)
    order = [*range(10), 60, 61, 0, 98, 99, 99]
    assert listener.received == as_received([written[number] for number in order])


def test_changes_at_random_moments_lose_and_double_nothing(node, listener, tmp_path):
    written = write_bag(tmp_path / "bag", count=600)
    came = threading.Semaphore(0)
    with Player(
        node, tmp_path / "bag", PlayOptions(rate=2.0), on_published=lambda _: came.release()
    ) as player:
        player.play()
        for number in range(60):
            assert came.acquire(timeout=20)
            (player.pause, player.resume, lambda: player.set_rate(5.0), player.toggle_paused)[
                number % 4
            ]()
            if player.is_paused:
                player.play_next()
            player.resume()
        assert player.wait(20)
    assert listener.received == as_received(written)


def test_an_invalid_rate_is_refused(node, tmp_path):
    write_bag(tmp_path / "bag", count=1)
    with Player(node, tmp_path / "bag") as player:
        assert not player.set_rate(0)
        assert not player.set_rate(-2)
        assert player.rate == 1.0
        assert player.set_rate(1.5)
        assert player.rate == 1.5


def test_what_latched_topics_had_before_comes_first(node, tmp_path):
    listener = Listener(node)
    listener.subscribe("/map", is_latched=True)
    listener.subscribe("/other")
    bag = [message(*each) for each in (("/map", 0), ("/other", 1), ("/map", 2), ("/other", 50))]
    with BagWriter(tmp_path / "bag", WriterOptions()) as writer:
        writer.add_topic(topic("/map", qos=LATCHED))
        writer.add_topic(topic("/other"))
        for each in bag:
            writer.write(each)
    play(node, tmp_path / "bag", replace(FAST, start_offset_ns=10 * MS))
    assert listener.received == as_received([bag[2], bag[3]])
    listener.received.clear()
    with Player(node, tmp_path / "bag", PAUSED) as player:
        player.play()
        player.seek(START_NS + MS)
        assert listener.received == as_received([bag[0]])


def test_static_transforms_of_all_broadcasters_come_first(node, tmp_path):
    kind = "tf2_msgs/msg/TFMessage"
    listener = Listener(node)
    listener.subscribe("/tf_static", kind, is_latched=True)
    one, other = (
        message("/tf_static", number, kind, transforms=[_transform(name)])
        for number, name in enumerate(("camera", "gripper"))
    )
    again = other._replace(log_time_ns=START_NS + 3 * MS)
    with BagWriter(tmp_path / "bag", WriterOptions()) as writer:
        writer.add_topic(topic("/tf_static", kind, LATCHED))
        writer.add_topic(topic("/other"))
        for each in (one, other, again, message("/other", 50)):
            writer.write(each)
    play(node, tmp_path / "bag", replace(FAST, start_offset_ns=10 * MS))
    assert listener.received == as_received([one, other])


def _transform(name: str):
    transform = get_message("geometry_msgs/msg/TransformStamped")()
    transform.child_frame_id = name
    return transform


def test_several_bags_are_merged_by_time(node, listener, tmp_path):
    written = [message(f"/topic_{number % 2}", number) for number in range(40)]
    for part in range(2):
        with BagWriter(tmp_path / f"bag_{part}", WriterOptions()) as writer:
            writer.add_topic(topic(f"/topic_{part}"))
            for each in written[part::2]:
                writer.write(each)
    play(node, [tmp_path / "bag_0", (tmp_path / "bag_1", "mcap")])
    assert listener.received == as_received(written)


def test_messages_come_in_the_order_in_which_they_were_sent(node, listener, tmp_path):
    sent = [3, 1, 2, 0, 5, 4]
    written = [
        message("/topic_0", number)._replace(publish_time_ns=START_NS + time * MS)
        for number, time in enumerate(sent)
    ]
    with BagWriter(tmp_path / "bag", WriterOptions()) as writer:
        writer.add_topic(topic("/topic_0"))
        for each in written:
            writer.write(each)
    play(node, tmp_path / "bag", replace(FAST, message_order="sent"))
    by_time = sorted(written, key=lambda each: each.publish_time_ns)
    assert listener.received == as_received(by_time)


def test_the_clock_tells_playback_time_with_each_message(node, tmp_path):
    clock_class = get_message("rosgraph_msgs/msg/Clock")
    times: list[int] = []
    node.create_subscription(
        clock_class, "/clock", lambda m: times.append(to_nanoseconds(m.clock)), 10, immediate=True
    )
    written = write_bag(tmp_path / "bag", count=10)
    options = PlayOptions(is_paused=True, clock_topics=("/topic_1",))
    with Player(node, tmp_path / "bag", options) as player:
        player.play()
        player.burst(3)
        assert times == [START_NS, written[1].log_time_ns]
        player.seek(START_NS)
        assert times[-1] == START_NS
    times.clear()
    with Player(node, tmp_path / "bag", PlayOptions(is_paused=True, clock_topics=None)) as player:
        player.play()
        player.burst()
    assert times == [START_NS, *(m.log_time_ns for m in written)]


def test_the_clock_runs_on_between_messages_and_stands_still_while_paused(node, tmp_path):
    with BagWriter(tmp_path / "long", WriterOptions()) as writer:
        writer.add_topic(topic("/topic_0"))
        writer.write(message("/topic_0", 0))
        writer.write(message("/topic_0", 3_600_000))
    clock_class = get_message("rosgraph_msgs/msg/Clock")
    changed = threading.Condition()
    times: list[int] = []

    def hear(clock) -> None:
        with changed:
            times.append(to_nanoseconds(clock.clock))
            changed.notify_all()

    node.create_subscription(clock_class, "/clock", hear, 10, immediate=True)
    options = PlayOptions(rate=100.0, clock_hz=200.0)
    with Player(node, tmp_path / "long", options) as player, changed:
        player.play()
        assert changed.wait_for(lambda: bool(times) and times[-1] > START_NS + 10**9, 20)
        player.pause()
        stood = player._playback_time.now_ns()
        seen = len(times)
        assert changed.wait_for(lambda: len(times) > seen + 3, 20)
        assert times[-1] == stood
    assert times == sorted(times)


def test_files_that_change_are_told(node, tmp_path):
    write_bag(tmp_path / "bag", count=30, options=WriterOptions(split_duration_ns=10 * MS))
    event_class = get_message("rosbag2_interfaces/msg/ReadSplitEvent")
    events: list[tuple[str, str, str]] = []
    node.create_subscription(
        event_class,
        "/events/read_split",
        lambda e: events.append((e.closed_file, e.opened_file, e.node_name)),
        10,
        immediate=True,
    )
    play(node, tmp_path / "bag")
    names = [str(tmp_path / "bag" / f"bag_{number}.mcap") for number in range(3)]
    assert events == [(names[0], names[1], "/player"), (names[1], names[2], "/player")]


def test_offers_are_those_that_were_recorded_unless_overridden(node, tmp_path):
    with BagWriter(tmp_path / "bag", WriterOptions()) as writer:
        writer.add_topic(topic("/map", qos=LATCHED))
        writer.add_topic(topic("/topic_0"))
        writer.add_topic(topic("/mixed")._replace(qos=(LATCHED, LATCHED._replace(durability=2))))
        writer.write(message("/map", 0))
    options = PlayOptions(qos_overrides={"topic_0": QoSProfile(depth=3)})
    with Player(node, tmp_path / "bag", options):
        offers = {p.name: p.qos_profile for p in node.publishers if p.type_name == STRING}
    assert offers["/map"].is_latched
    assert offers["/map"].depth == 1
    assert offers["/topic_0"] == QoSProfile(depth=3)
    assert offers["/mixed"] == QoSProfile(depth=10)


def test_a_player_leaves_nothing_behind(node, tmp_path):
    write_bag(tmp_path / "bag", count=3)
    before = {*node.publishers, *node.services}
    play(node, tmp_path / "bag", replace(FAST, clock_hz=10.0))
    assert {*node.publishers, *node.services} == before
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("bag-")]


def test_the_end_of_the_context_ends_playing(shared_ros, tmp_path):
    write_bag(tmp_path / "bag", count=2)
    context = Context()
    context.init([])
    with Node("player", context=context) as node, Player(node, tmp_path / "bag", PAUSED) as player:
        player.play()
        context.try_shutdown()
        assert player.wait(20)


def test_what_cannot_be_played_is_told(node, tmp_path):
    with pytest.raises(NotFoundError, match="does not exist"):
        Player(node, tmp_path / "none")
    (tmp_path / "bag.mcap").write_bytes(b"nothing")
    with pytest.raises(InvalidFileError):
        Player(node, tmp_path / "bag.mcap")
    with pytest.raises(UsageError, match="no input bags"):
        Player(node, [])
    with pytest.raises(UsageError, match="regular expression"):
        PlaySelection(regex="(")


def test_a_topic_of_an_unknown_type_without_a_definition_is_left_out(node, listener, tmp_path):
    strange = topic("/strange")._replace(
        type_name="nowhere_msgs/msg/Thing", type_hash="", definition=topic("/x").definition
    )
    strange = strange._replace(definition=strange.definition._replace(encoding="", text=""))
    good = message("/topic_0", 0)
    with BagWriter(tmp_path / "bag", WriterOptions()) as writer:
        writer.add_topic(strange)
        writer.add_topic(topic("/topic_0"))
        writer.write(BagMessage("/strange", START_NS, START_NS, b"?"))
        writer.write(good)
    play(node, tmp_path / "bag")
    assert listener.received == as_received([good])
