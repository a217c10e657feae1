"""The buffer speaks messages, waits, and may be asked from any thread."""

import threading

import pytest
import yaml

from teleopctl.interfaces.store import get_message
from teleopctl.node import Duration, Time
from teleopctl.tf.buffer import Buffer
from teleopctl.tf.buffer_core import BufferCore
from teleopctl.tf.errors import (
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from teleopctl.tf.messages import transform_stamped
from teleopctl.tf.transforms import Transform, quaternion_from_rpy

S = 1_000_000_000
NOW = Time()


def stamped(parent, child, seconds, x):
    return transform_stamped(parent, child, int(seconds * S), Transform((float(x), 0.0, 0.0)))


@pytest.fixture
def buffer():
    made = Buffer()
    made.set_transform_static(stamped("world", "base", 0, 1))
    made.set_transform(stamped("base", "hand", 1, 1))
    made.set_transform(stamped("base", "hand", 2, 3))
    return made


def test_an_answer_is_a_stamped_message(buffer):
    answer = buffer.lookup_transform("world", "hand", Time(seconds=1.5))
    assert answer.header.frame_id == "world"
    assert answer.child_frame_id == "hand"
    assert (answer.header.stamp.sec, answer.header.stamp.nanosec) == (1, 500_000_000)
    assert answer.transform.translation.x == pytest.approx(3.0)
    assert answer.transform.rotation.w == 1.0


def test_times_may_be_messages(buffer):
    time = get_message("builtin_interfaces/msg/Time")(sec=2)
    assert buffer.lookup_transform("base", "hand", time).transform.translation.x == 3.0


def test_time_zero_is_the_newest(buffer):
    assert buffer.lookup_transform("world", "hand", NOW).header.stamp.sec == 2
    newest = buffer.get_latest_common_time("world", "hand")
    assert newest == Time(seconds=2)


def test_can_transform_tells_why_not(buffer):
    assert buffer.can_transform("world", "hand", NOW)
    assert buffer.can_transform("world", "hand", NOW, return_debug_tuple=True) == (True, "")
    assert not buffer.can_transform("world", "nowhere", NOW)
    known, reason = buffer.can_transform("world", "nowhere", NOW, return_debug_tuple=True)
    assert not known
    assert 'Invalid frame ID "nowhere"' in reason


def test_the_full_lookup_goes_through_a_fixed_frame(buffer):
    arguments = ("hand", Time(seconds=2), "hand", Time(seconds=1), "world")
    assert buffer.can_transform_full(*arguments)
    assert buffer.lookup_transform_full(*arguments).transform.translation.x == pytest.approx(-2.0)


def test_lookup_waits_until_the_transform_arrives(buffer):
    asked = threading.Event()
    answers = []

    def ask():
        asked.set()
        answers.append(buffer.lookup_transform("world", "tool", NOW, Duration(seconds=20)))

    thread = threading.Thread(target=ask)
    thread.start()
    asked.wait(20)
    buffer.set_transform(stamped("hand", "tool", 2, 1))
    thread.join(20)
    assert answers[0].transform.translation.x == pytest.approx(5.0)


def test_a_wait_ends_with_the_reason(buffer):
    with pytest.raises(LookupException):
        buffer.lookup_transform("world", "tool", NOW, Duration(seconds=0.01))
    with pytest.raises(ExtrapolationException):
        buffer.lookup_transform("world", "hand", Time(seconds=9))


def test_clearing_forgets_what_moved(buffer):
    buffer.clear()
    assert buffer.can_transform("world", "base", NOW)
    assert not buffer.can_transform("world", "hand", NOW)


def test_all_frames_are_listed(buffer):
    assert buffer.all_frames_as_string() == (
        "Frame base exists with parent world.\nFrame hand exists with parent base.\n"
    )
    assert yaml.safe_load(buffer.all_frames_as_yaml())["hand"] == {
        "parent": "base",
        "broadcaster": "default_authority",
        "rate": 2.0,
        "most_recent_transform": 2.0,
        "oldest_transform": 1.0,
        "buffer_length": 1.0,
        "is_static": False,
    }
    assert set(buffer.frame_names()) == {"world", "base", "hand"}


def test_the_frames_are_a_graph(buffer):
    label = "Broadcaster: default_authority\\nAverage rate: 2.000 Hz\\n"
    seen = "Most recent transform: 2.000000 ( 1.500 sec old)\\nBuffer length: 1.000 sec\\n"
    lines = buffer._allFramesAsDot(Time(seconds=3.5)).splitlines()
    assert f'"base" -> "hand"[label="{label}{seen}"];' in lines
    assert lines[-3:-1] == ['"Recorded at time: 3.500000"[ shape=plaintext ] ;', ' }->"world";']
    assert '"world" -> "base"' in buffer._allFramesAsDot()
    assert "sec old" not in buffer._allFramesAsDot()
    assert "no tf data recieved" in BufferCore()._allFramesAsDot()


def test_a_chain_names_the_frames_between(buffer):
    buffer.set_transform(stamped("base", "eye", 1, 1))
    at = Time(seconds=1.0)
    assert buffer._chain("base", at, "hand", at, "world") == ["hand", "base", "world"]
    assert buffer._chain("world", at, "world", at, "hand") == ["world", "base", "hand"]
    assert buffer._chain("base", at, "eye", at, "hand") == ["eye", "base", "hand"]
    assert buffer._chain("eye", at, "hand", NOW, "base") == ["hand", "base", "eye"]
    with pytest.raises(LookupException):
        buffer._chain("world", at, "nobody", at, "hand")
    with pytest.raises(ExtrapolationException):
        buffer._chain("world", at, "hand", Time(seconds=9.0), "world")


def test_the_cache_time_can_be_chosen():
    buffer = Buffer(Duration(seconds=1))
    for n in range(20):
        buffer.set_transform(stamped("a", "b", 1 + n / 4, n))
    with pytest.raises(TransformException, match="into the past"):
        buffer.lookup_transform("a", "b", Time(seconds=2))


def test_many_threads_may_write_and_read(buffer):
    failures = []

    def work(name):
        try:
            for n in range(200):
                buffer.set_transform(stamped("base", name, 1 + n / 100, n))
                buffer.lookup_transform("world", name, NOW)
        except TransformException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(f"t{n}",)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert failures == []


def test_a_frame_stands_in_itself_even_if_nobody_knows_it(buffer):
    answer = buffer.lookup_transform("nowhere", "nowhere", Time(seconds=5))
    assert (answer.header.frame_id, answer.child_frame_id) == ("nowhere", "nowhere")
    assert answer.header.stamp.sec == 5
    assert answer.transform.rotation.w == 1.0
    assert buffer.can_transform("nowhere", "nowhere", NOW)


def test_the_core_answers_at_once_or_says_why_not():
    core = BufferCore()
    core.set_transform(stamped("a", "b", 1, 1), "me")
    core.set_transform(stamped("a", "b", 2, 3), "me")
    assert core.can_transform_core("a", "b", Time(seconds=1.5)) == (True, "")
    answer = core.lookup_transform_core(target_frame="a", source_frame="b", time=Time(seconds=1.5))
    assert answer.transform.translation.x == pytest.approx(2.0)
    known, reason = core.can_transform_core("a", "b", Time(seconds=3))
    assert not known
    assert "extrapolation into the future" in reason
    assert core.can_transform_full_core("b", Time(seconds=1), "b", Time(seconds=2), "a")[0]
    moved = core.lookup_transform_full_core("b", Time(seconds=1), "b", Time(seconds=2), "a")
    assert moved.transform.translation.x == pytest.approx(2.0)
    with pytest.raises(LookupException):
        core.lookup_transform_core("a", "c", NOW)


def test_velocities_are_differences_over_time():
    core = BufferCore()
    for n in range(5):
        turn = quaternion_from_rpy(0.0, 0.0, 0.5 * n)
        place = Transform((3.0 * n, 0.0, 0.0), turn)
        core.set_transform(transform_stamped("world", "hand", n * S, place), "me")
    linear, angular = core.lookupVelocityCore("hand", "world", Time(seconds=2), Duration(seconds=2))
    assert linear == pytest.approx((3.0, 0.0, 0.0))
    assert angular == pytest.approx((0.0, 0.0, 0.5))
    # A point a metre to the left in the world goes back as fast as the frame turns.
    point = (6.0, 1.0, 0.0)
    linear, _ = core.lookupVelocityFullCore(
        "hand", "world", "world", point, "world", Time(seconds=2), Duration(seconds=2)
    )
    assert linear == pytest.approx((2.5, 0.0, 0.0))
    with pytest.raises(InvalidArgumentException, match="longer than 0 s"):
        core.lookupVelocityCore("hand", "world", Time(seconds=2), Duration())
