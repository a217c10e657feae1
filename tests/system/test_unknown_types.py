"""Types that are not built in are learnt from the node that uses them."""

import pytest

GOALS = "strange_msgs/msg/Goals"


def test_echo_prints_messages_of_a_type_that_their_publisher_explains(ros, stranger):
    done = ros.run("topic echo /goals --once")
    assert done.stdout == "names:\n- here\n- there\nwhere:\n  x: 2.5\n---\n"
    assert (done.stderr, done.returncode) == ("", 0)


def test_pub_sends_messages_of_a_type_that_their_subscriber_explains(ros, stranger):
    done = ros.run(["topic", "pub", "--once", "/wishes", GOALS, "{names: [peace, quiet]}"])
    assert done.returncode == 0
    stranger.wait_for_line("wished for peace quiet")


def test_service_call_sends_a_request_of_a_type_that_the_server_explains(ros, stranger):
    request = "{goals: {names: [a, b, c]}}"
    done = ros.run(["service", "call", "/pick", "strange_msgs/srv/Pick", request])
    assert "strange_msgs.srv.Pick_Response(number=3)" in done.stdout


@pytest.mark.parametrize("verb", ["hz", "bw", "echo --raw"])
def test_verbs_that_read_no_message_need_no_type(ros, start_stranger, verb):
    start_stranger("--ros-args", "-p", "start_type_description_service:=false")
    meter = ros.spawn(f"topic {verb} /goals")
    meter.wait_for_line({"hz": "average rate", "bw": "/s from", "echo --raw": "b'"}[verb])


def test_a_type_that_nobody_explains_stays_unknown(ros, start_stranger):
    start_stranger("--ros-args", "-p", "start_type_description_service:=false")
    done = ros.run("topic echo --once /goals")
    assert done.returncode != 0
    assert "Unknown interface type strange_msgs/msg/Goals" in done.stderr


def test_a_type_that_nobody_uses_stays_unknown(ros, stranger):
    done = ros.run("topic pub --once /wishes strange_msgs/msg/Other {}")
    assert done.returncode != 0
    assert "Unknown interface type strange_msgs/msg/Other" in done.stderr
