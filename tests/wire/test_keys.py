import pytest
from hypothesis import given, strategies as st

from teleopctl.wire.keys import ANY_HASH, TopicKey, liveliness_key, parse_topic_key, topic_key

STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
FIB_HASH = "RIHS01_d1a57fb2a4afe8c21e34fb10db206f16ce6729b28531141472df92277c55b557"

VECTORS = [
    (
        TopicKey(0, "/chatter", "std_msgs/msg/String", STRING_HASH),
        f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    ),
    (
        TopicKey(0, "/robot1/chatter", "std_msgs/msg/String", STRING_HASH),
        f"0/robot1/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    ),
    (
        TopicKey(2, "/add_two_ints", "example_interfaces/srv/AddTwoInts", ADD_HASH),
        f"2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}",
    ),
    (
        TopicKey(
            0,
            "/fib/_action/send_goal",
            "example_interfaces/action/Fibonacci_SendGoal",
            FIB_HASH,
        ),
        f"0/fib/_action/send_goal/example_interfaces::action::dds_::Fibonacci_SendGoal_/{FIB_HASH}",
    ),
]

NAME_PART = st.from_regex(r"[a-z_][a-z0-9_]{0,8}", fullmatch=True)
NAME = st.lists(NAME_PART, min_size=1, max_size=4).map(lambda parts: "/" + "/".join(parts))
TYPE_NAME = st.builds(
    "{}/{}/{}".format,
    st.from_regex(r"[a-z][a-z0-9_]{0,9}", fullmatch=True).filter(lambda s: "dds_" not in s),
    st.sampled_from(["msg", "srv", "action"]),
    st.from_regex(r"[A-Z][A-Za-z0-9_]{0,9}", fullmatch=True),
)
TYPE_HASH = st.from_regex(r"RIHS01_[0-9a-f]{64}", fullmatch=True)


@pytest.mark.parametrize(("key", "text"), VECTORS)
def test_known_keys_are_written_and_read(key, text):
    assert topic_key(*key) == text
    assert parse_topic_key(text) == key


def test_only_one_slash_is_dropped_at_either_end():
    text = topic_key(0, "/a/b/", "std_msgs/msg/String", ANY_HASH)
    assert text == "0/a/b/std_msgs::msg::dds_::String_/*"


@pytest.mark.parametrize("suffix", ["_buf_cpu", "_buf/0123456789abcdef"])
def test_the_extra_levels_of_buffer_aware_topics_are_dropped(suffix):
    key, text = VECTORS[1]
    assert parse_topic_key(f"{text}/{suffix}") == key


@given(st.integers(0, 232), NAME, TYPE_NAME, TYPE_HASH)
def test_every_key_survives_the_wire(domain, name, type_name, type_hash):
    text = topic_key(domain, name, type_name, type_hash)
    assert parse_topic_key(text) == (domain, name, type_name, type_hash)


@given(st.text() | st.lists(st.text(max_size=5), max_size=8).map("/".join))
def test_garbage_never_raises(text):
    key = parse_topic_key(text)
    assert key is None or isinstance(key, TopicKey)


@pytest.mark.parametrize("text", ["", "0", "0/a/b", "x/a/t/h", "0//t/h", "/0/a/t/h", "_buf_cpu"])
def test_a_text_of_another_form_is_no_key(text):
    assert parse_topic_key(text) is None


def test_all_tokens_of_a_domain_have_one_expression():
    assert liveliness_key(7) == "@ros2_lv/7/**"
