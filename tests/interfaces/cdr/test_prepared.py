"""Messages that are written in place are those that would have been serialised."""

from array import array

from hypothesis import given, strategies as st

from teleopctl.interfaces import PreparedMessage, get_message, serialize, set_stamp
from tests.interfaces.messages import messages

JointState = get_message("sensor_msgs/msg/JointState")
NUMBERS = ("position", "velocity", "effort")


@given(messages("sensor_msgs/msg/JointState", True), st.data(), st.integers(0, 2**31 * 10**9 - 1))
def test_what_is_written_in_place_is_what_would_be_serialised(message, data, time_ns: int) -> None:
    prepared = PreparedMessage(message, NUMBERS)
    assert prepared.data == serialize(message)

    for name in NUMBERS:
        count = len(getattr(message, name))
        new = array("d", data.draw(st.lists(st.floats(), min_size=count, max_size=count)))
        setattr(message, name, new)
        prepared.numbers[name][:] = memoryview(new)
    set_stamp(message.header.stamp, time_ns)
    prepared.set_stamp(time_ns)

    assert prepared.data == serialize(message)
