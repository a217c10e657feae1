"""The verbs of ``teleopctl topic`` between real processes."""

import json
import re
import signal

import pytest

from teleopctl.testing import eventually
from teleopctl.wire.graph_watcher import GraphWatcher
from teleopctl.wire.session import open_session

STRING = "std_msgs/msg/String"
HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"


def talker(ros, *options, topic="/chatter", values="{data: 'Hello, World'}", kind=STRING):
    """A publishing process that is under way."""
    process = ros.spawn(["topic", "pub", *options, topic, kind, values])
    process.wait_for_line("publisher: beginning loop")
    return process


def test_list_shows_names_types_counts_and_endpoints(ros):
    talker(ros)
    hidden = talker(ros, topic="/_secret")
    assert ros.run("topic list").stdout == "/chatter\n/parameter_events\n"
    with_types = ros.run("topic list -t").stdout.splitlines()
    assert with_types[0] == "/chatter [std_msgs/msg/String]"
    assert ros.run("topic list -c").stdout == "2\n"
    assert "/_secret" in ros.run("topic list --include-hidden-topics").stdout
    assert ros.run("topic list -v").stdout == (
        "Published topics:\n"
        " * /chatter [std_msgs/msg/String] 1 publisher\n"
        " * /parameter_events [rcl_interfaces/msg/ParameterEvent] 2 publishers\n"
        "\n"
        "Subscribed topics:\n"
        "\n"
    )
    records = json.loads(ros.run("topic list --json").stdout)
    assert records[0] == {
        "name": "/chatter",
        "types": [STRING],
        "publishers": 1,
        "subscribers": 0,
    }
    hidden.interrupt()
    assert hidden.wait() == 130


def test_an_empty_graph_is_an_empty_list(ros):
    done = ros.run("topic list")
    assert (done.stdout, done.stderr, done.returncode) == ("", "", 0)
    for verb in ("hz", "bw"):
        done = ros.run(f"topic {verb} --all")
        assert (done.stdout, done.stderr, done.returncode) == ("No topics available\n", "", 0)


def test_info_counts_and_describes_endpoints(ros):
    publisher = talker(ros, "--qos-depth", "7", "-n", "talker")
    short = ros.run("topic info chatter")
    assert short.stdout == (
        "Type: std_msgs/msg/String\nPublisher count: 1\nSubscription count: 0\n"
    )
    assert short.stderr == ""
    long = ros.run("topic info -v /chatter").stdout
    gid = re.search(r"GID: ((?:[0-9a-f]{2}\.){15}[0-9a-f]{2})\n", long)
    assert gid is not None
    assert long == (
        "Type: std_msgs/msg/String\n"
        "\n"
        "Publisher count: 1\n"
        "\n"
        "Node name: talker\n"
        "Node namespace: /\n"
        "Topic type: std_msgs/msg/String\n"
        f"Topic type hash: {HASH}\n"
        "Endpoint type: PUBLISHER\n"
        f"GID: {gid[1]}\n"
        "QoS profile:\n"
        "  Reliability: RELIABLE\n"
        "  History (Depth): KEEP_LAST (7)\n"
        "  Durability: VOLATILE\n"
        "  Lifespan: Infinite\n"
        "  Deadline: Infinite\n"
        "  Liveliness: AUTOMATIC\n"
        "  Liveliness lease duration: Infinite\n"
        "\n"
        "Subscription count: 0\n"
        "\n"
    )
    record = json.loads(ros.run("topic info --json /chatter").stdout)
    assert record["publishers"][0]["qos"]["depth"] == 7
    assert record["publishers"][0]["gid"] == gid[1].replace(".", "")
    publisher.terminate()
    assert publisher.wait() == -signal.SIGTERM


def test_info_says_when_two_ends_cannot_understand_each_other(ros):
    talker(ros)
    with open_session("client") as session:
        token = (
            f"@ros2_lv/{ros.domain}/{session.zid()}/0/1/MS/%/%/old/%chatter/"
            "std_msgs::msg::dds_::String_/TypeHashNotSupported/::,10:,:,:,,"
        )
        declared = session.liveliness().declare_token(token)
        done = ros.run("topic info /chatter")
        declared.undeclare()
    assert "Subscription count: 1" in done.stdout
    assert "type hashes differ" in done.stderr
    assert "/old" in done.stderr
    assert done.returncode == 0


def test_info_says_where_a_publisher_offers_less_than_a_subscription_asks_for(ros):
    talker(ros, "--qos-reliability", "best_effort", "-n", "mouth")
    listener = ros.spawn(f"topic echo /chatter {STRING} --qos-reliability reliable -n ear")
    listener.wait_for_line("^---$")
    done = ros.run("topic info /chatter")
    assert done.returncode == 0
    assert done.stderr == (
        "WARNING: /chatter: /mouth and /ear: reliability: BEST_EFFORT publisher and RELIABLE "
        "subscription. They communicate over Zenoh, with the QoS that the publisher offers; over "
        "DDS they do not.\n"
    )
    listener.interrupt()
    assert listener.wait() == 130


def test_type_and_find(ros):
    talker(ros)
    assert ros.run("topic type /chatter").stdout == f"{STRING}\n"
    assert ros.run("topic find std_msgs/msg/String").stdout == "/chatter\n"
    assert ros.run("topic find -c std_msgs/String").stdout == "1\n"
    assert json.loads(ros.run("topic type /chatter --json").stdout) == [STRING]
    assert json.loads(ros.run("topic find std_msgs/msg/String --json").stdout) == ["/chatter"]


def test_echo_prints_what_pub_sends(ros):
    listener = ros.spawn(f"topic echo /chatter {STRING}")
    sender = ros.run(["topic", "pub", "--once", "/chatter", STRING, "{data: 'Hello, World'}"])
    assert sender.returncode == 0
    assert sender.stdout == (
        "publisher: beginning loop\npublishing #1: std_msgs.msg.String(data='Hello, World')\n\n"
    )
    listener.wait_for_line("^---$")
    assert listener.stdout == "data: Hello, World\n---\n"
    listener.interrupt()
    assert listener.wait() == 130
    assert listener.stderr == ""


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], "data: Hello, World\n---\n"),
        (["--field", "data"], "Hello, World\n---\n"),
        (["--field", "data", "--field", "data"], "Hello, World\nHello, World\n---\n"),
        (["--json", "--field", "data", "--field", "data"], '{"data": "Hello, World"}\n'),
        (["--csv"], "Hello, World\n"),
        (["--csv", "--field", "data", "--field", "data"], "Hello, World,Hello, World\n"),
        (["--no-str"], "data: '<string length: <12>>'\n---\n"),
        (["--json"], '{"data": "Hello, World"}\n'),
        (["--json", "--field", "data"], '"Hello, World"\n'),
        (["-l", "5"], "data: Hello...\n---\n"),
        (["--raw"], "b'\\x00\\x01\\x00\\x00\\r\\x00\\x00\\x00Hello, World\\x00'\n---\n"),
        (["--filter", "m.data.startswith('Hello')"], "data: Hello, World\n---\n"),
    ],
)
def test_echo_once_in_every_form(shared_talker, options, expected):
    done = shared_talker.run(["topic", "echo", "--once", *options, "/chatter"])
    assert (done.stdout, done.stderr, done.returncode) == (expected, "", 0)


def test_who_hears_one_message_is_a_node_with_a_subscription(shared_talker):
    never = ["--filter", "m.data == 'never'"]
    listener = shared_talker.spawn(["topic", "echo", "--once", "-n", "ear", *never, "/chatter"])
    shared_talker.wait_for_nodes("/ear")

    def qos_of_ear():
        subscriptions = shared_talker.node.graph().subscriptions("/chatter", STRING)
        return [each.qos.depth for each in subscriptions if each.full_name == "/ear"]

    eventually(lambda: qos_of_ear() == [10])
    listener.interrupt()
    assert listener.wait() == 130
    eventually(lambda: qos_of_ear() == [])


@pytest.fixture(scope="module")
def shared_talker(shared_ros):
    talker(shared_ros, "-r", "20")
    return shared_ros


def test_echo_with_message_info(shared_talker):
    done = shared_talker.run("topic echo --once --include-message-info /chatter")
    keys = [line.partition(":")[0] for line in done.stdout.splitlines()]
    assert keys == [
        "publication_sequence_number",
        "received_timestamp",
        "reception_sequence_number",
        "source_timestamp",
        "---",
        "data",
        "---",
    ]


def test_echo_of_a_field_with_message_info(shared_talker):
    done = shared_talker.run("topic echo --once -i --field data /chatter")
    assert re.fullmatch(
        r"---Got new message, message info:---\n"
        r"\{'source_timestamp': \d+, 'received_timestamp': \d+, "
        r"'publication_sequence_number': \d+, 'reception_sequence_number': 0\}\n"
        r"---Message data:---\nHello, World\n---\n",
        done.stdout,
    )


def test_echo_of_several_topics_names_the_topic_of_each_message(shared_talker):
    both = shared_talker.spawn(f"topic echo /chatter {STRING} /chatter2 {STRING}")
    talker(shared_talker, topic="/chatter2", values="data: two")
    both.wait_for_line("^# /chatter$")
    both.wait_for_line("^# /chatter2$")
    as_json = shared_talker.spawn("topic echo --json '/chat*'")
    line = as_json.wait_for_line('.*"/chatter2".*')[0]
    assert json.loads(line) == {"topic": "/chatter2", "message": {"data": "two"}}
    fit_nothing = shared_talker.run("topic echo '/nothing/*'")
    assert (fit_nothing.returncode, fit_nothing.stdout) == (1, "")
    assert "No topic fits '/nothing/*'" in fit_nothing.stderr


def test_echo_with_a_filter_that_nothing_passes_ends_by_timeout(shared_talker):
    done = shared_talker.run("topic echo --filter 'm.data == 1' --timeout 0.3 /chatter")
    assert (done.stdout, done.returncode) == ("", 1)
    assert "No message on '/chatter' within 0.3 s" in done.stderr


@pytest.mark.parametrize("verb", ["echo", "hz"])
def test_a_filter_that_fails_ends_the_command_with_one_sentence(shared_talker, verb):
    done = shared_talker.run(["topic", verb, "--filter", "data > 3", "/chatter"])
    assert (done.stdout, done.returncode) == ("", 1)
    assert done.stderr == (
        "teleopctl: Filter expression 'data > 3' failed: name 'data' is not defined\n"
        "  The message is m: --filter 'm.data > 3'\n"
    )


def test_echo_of_a_field_that_is_not_there(shared_talker):
    done = shared_talker.run("topic echo --once --field date /chatter")
    assert done.returncode == 1
    assert "has no field 'date'" in done.stderr
    assert "its fields are data" in done.stderr


def test_hz_prints_the_rate(shared_talker):
    meter = shared_talker.spawn("topic hz --wall-time -w 10 /chatter")
    rate = float(meter.wait_for_line(r"^average rate: (\d+\.\d{3})$")[1])
    assert rate > 0
    meter.wait_for_line(r"^\tmin: \d\.\d{3}s max: \d\.\d{3}s std dev: \d\.\d{5}s window: \d+$")
    meter.interrupt()
    assert meter.wait() == 130
    assert meter.stderr == ""


def test_bw_prints_the_bandwidth(shared_talker):
    meter = shared_talker.spawn("topic bw /chatter")
    meter.wait_for_line(r"^Subscribed to \[/chatter\]$")
    meter.wait_for_line(r"^\d+ B/s from \d+ messages$")
    meter.wait_for_line(r"^\tMessage size mean: 21 B min: 21 B max: 21 B$")


def test_what_is_measured_may_begin_later(ros):
    meters = [ros.spawn(f"topic {verb} /point") for verb in ("hz", "bw", "delay")]
    for meter in meters:
        meter.wait_for_line(r"^WARNING: topic \[/point\] does not appear to be published yet$")
    kind, values = "geometry_msgs/msg/PointStamped", "header: auto"
    talker(ros, "-r", "20", topic="/point", kind=kind, values=values)
    texts = (r"^average rate: \d", r"^Subscribed to \[/point\]$", r"^average delay: \d")
    for meter, text in zip(meters, texts, strict=True):
        meter.wait_for_line(text)


def test_hz_of_several_topics_is_a_table_as_ros2s(shared_talker):
    meter = shared_talker.spawn("topic hz /chatter /parameter_events /nothing")
    meter.wait_for_line(r"^Subscribed to \[/chatter\]$")
    header = meter.wait_for_line(r"^ *topic +rate +min_delta +max_delta +std_dev +window *$")[0]
    assert meter.wait_for_line("^=+$")[0] == "=" * len(header)
    row = meter.wait_for_line(r"^/chatter   \d+\.\d{3} *   \d\.\d{3} *   \d\.\d{3}.*$")[0]
    assert len(row) == len(header)


def test_what_echo_printed_is_published_message_by_message(ros, tmp_path):
    file = tmp_path / "messages.yaml"
    file.write_text("# /chatter\ndata: one\n---\n# /chatter\ndata: two\n---\n")
    done = ros.run(f"topic pub -r 100 --yaml-file {file} /chatter {STRING}")
    assert done.stdout == (
        "publisher: beginning loop\n"
        "publishing #1: std_msgs.msg.String(data='one')\n\n"
        "publishing #2: std_msgs.msg.String(data='two')\n\n"
    )
    lines = '{"data": "one"}\n{"data": "two"}\n'
    again = ros.run(f"topic pub -r 100 --stdin /chatter {STRING}", input=lines)
    assert again.stdout == done.stdout
    broken = ros.run(f"topic pub --stdin /chatter {STRING}", input="data: one\n---\ndate: two\n")
    assert (broken.stdout, broken.returncode) == ("", 1)


def test_simulated_time_is_that_of_clock(ros):
    talker(ros, topic="/clock", kind="rosgraph_msgs/msg/Clock", values="clock: {sec: 500}")
    stamped = ros.run(
        ["topic", "pub", "-s", "-w", "0", "-1", "/h", "std_msgs/msg/Header", "stamp: now"]
    )
    assert "sec=500, nanosec=0" in stamped.stdout
    kind, values = "geometry_msgs/msg/PointStamped", "header: {stamp: {sec: 498}}"
    talker(ros, "-r", "20", topic="/point", kind=kind, values=values)
    ros.spawn("topic delay -s /point").wait_for_line(r"^average delay: 2\.000$")


def test_delay_needs_a_header(shared_talker):
    done = shared_talker.run("topic delay /chatter")
    assert done.returncode == 1
    assert "msg does not have header: std_msgs/msg/String" in done.stderr


def test_delay_of_stamped_messages(ros):
    talker(
        ros,
        "-r",
        "20",
        topic="/point",
        kind="geometry_msgs/msg/PointStamped",
        values="header: auto",
    )
    meter = ros.spawn("topic delay /point")
    assert 0 <= float(meter.wait_for_line(r"^average delay: (\d+\.\d{3})$")[1]) < 10


def test_echo_gets_latched_messages_of_the_past(ros):
    talker(ros, "--qos-durability", "transient_local", "-r", "0.001")
    eventually(lambda: "/chatter\n" in ros.run("topic list").stdout)
    done = ros.run("topic echo --once /chatter")
    assert done.stdout == "data: Hello, World\n---\n", done.stderr


def test_pub_times_rate_and_print(ros):
    listener = ros.spawn(f"topic echo /count {STRING}")
    sender = ros.run(["topic", "pub", "-t", "4", "-r", "50", "-p", "2", "/count", STRING])
    assert sender.stdout == (
        "publisher: beginning loop\n"
        "publishing #2: std_msgs.msg.String(data='')\n"
        "\n"
        "publishing #4: std_msgs.msg.String(data='')\n"
        "\n"
    )
    for _ in range(4):
        listener.wait_for_line("^---$")


def test_pub_waits_for_its_subscriber(ros):
    sender = ros.spawn(["topic", "pub", "--once", "/late", STRING, "data: now"])
    sender.wait_for_line(r"^Waiting for at least 1 matching subscription\(s\)\.\.\.$")
    listener = ros.run(f"topic echo --once /late {STRING}")
    assert listener.stdout == "data: now\n---\n"
    assert sender.wait() == 0


@pytest.mark.parametrize("stop", ["terminate", "interrupt"])
@pytest.mark.parametrize(
    "line",
    [
        f"topic pub --once /unheard {STRING}",
        f"topic pub -p 0 /unheard {STRING}",
        f"topic echo /unheard {STRING}",
        "topic hz /parameter_events",
    ],
)
def test_a_signal_ends_whatever_it_waits_for(shared_talker, line, stop):
    process = shared_talker.spawn(line)
    with open_session("client") as session:
        watcher = GraphWatcher(session)
        name = f"_ros2cli_{process.pid}"
        assert watcher.wait_for(lambda graph: graph.find_node(f"/{name}") is not None, 20.0)
        watcher.close()
    getattr(process, stop)()
    # Python ends by the signal itself where it interrupted code made with exec(), as that of
    # a dataclass; a shell shows 130 either way.
    assert process.wait() in (130, -signal.SIGINT, -signal.SIGTERM)
    assert process.stderr in ("", "Waiting for at least 1 matching subscription(s)...\n")


def test_pub_gives_up_waiting(ros):
    done = ros.run(f"topic pub --once --max-wait-time-secs 0.1 /late {STRING}")
    assert done.returncode == 1
    assert (
        "Timed out waiting for subscribers: Expected 1 subcribers but only got 0 subscribers"
        in done.stderr
    )


def test_pub_does_not_take_a_subscriber_of_another_type_for_its_own(ros):
    ros.spawn("run simple_subscriber")
    eventually(lambda: ros.run("topic type /chatter").stdout == f"{STRING}\n")
    done = ros.run("topic pub --once --max-wait-time-secs 0.1 /chatter std_msgs/msg/Int32")
    assert done.returncode == 1
    assert done.stderr.splitlines()[:2] == [
        "Waiting for at least 1 matching subscription(s)...",
        f"'/chatter' has the type {STRING}, not std_msgs/msg/Int32.",
    ]
    # The messages of a file go through the router, which knows the subscriber for certain; a peer
    # sees it as soon as the two are connected.
    (ros.folder / "numbers.yaml").write_text("data: 1\n---\ndata: 2\n")
    played = f"--yaml-file {ros.folder / 'numbers.yaml'} -w 0 --rate 100"
    done = ros.run(f"topic pub {played} /chatter std_msgs/msg/Int32")
    assert done.returncode == 0
    assert done.stderr == f"'/chatter' has the type {STRING}, not std_msgs/msg/Int32.\n"


@pytest.mark.parametrize("option", ["--stdin", "--yaml-file -"])
def test_pub_reads_standard_input(ros, option):
    listener = ros.spawn(f"topic echo /chatter {STRING}")
    sender = ros.run(f"topic pub --once {option} /chatter {STRING}", input="data: typed\n")
    assert sender.returncode == 0
    listener.wait_for_line("^data: typed$")


def test_the_commands_own_nodes_are_hidden(ros):
    listener = ros.spawn(f"topic echo /chatter {STRING}")
    sender = ros.spawn(["topic", "pub", "/chatter", STRING, "data: x"])
    listener.wait_for_line("data: x")
    assert ros.run("node list").stdout == ""
    names = ros.run("node list -a").stdout.splitlines()
    assert sorted(names) == sorted([f"/_ros2cli_{listener.pid}", f"/_ros2cli_{sender.pid}"])
