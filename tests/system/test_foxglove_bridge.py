"""``foxglove_bridge`` between real nodes and a client that speaks its protocol."""

import struct
import threading

import pytest

from teleopctl.interfaces import deserialize, get_message, get_service, serialize
from teleopctl.node import QoSProfile, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.testing import LONGEST_WAIT_S, eventually
from tests.samples import sample
from tests.system.foxglove_client import ASSET, SERVICE_RESPONSE, TIME, FoxgloveClient

STRING = get_message("std_msgs/msg/String")
MESH = "package://teleop_description/meshes"


def start(ros, *options):
    """A bridge on a free port; returns the process and the port."""
    words = [word for option in ("port:=0", *options) for word in ("-p", option)]
    process = ros.spawn(["run", "foxglove_bridge", "foxglove_bridge", "--ros-args", *words])
    match = process.wait_for_line(r"Server listening on ws://127\.0\.0\.1:(\d+)", stream="stderr")
    return process, int(match[1])


@pytest.fixture
def client(ros):
    _, port = start(ros)
    with FoxgloveClient(port) as connected:
        yield connected


def publisher_of(ros, topic, qos=10):
    return ros.node.create_publisher(STRING, topic, qos)


def knows_parameters_of(client, node_name):
    """Wait until the bridge reaches the services of a node; it asks no earlier than it is told."""
    for service in ("list_parameters", "get_parameters", "set_parameters"):
        client.until(lambda name=f"{node_name}/{service}": client.services.get(name))


def test_messages_pass_as_they_are_with_the_definition_of_their_type(ros, client):
    # Kept for late subscribers: the SDK may refuse the client's first wish.
    publisher = publisher_of(ros, "/chatter", qos_profile_latched)
    client.subscribe("/chatter", 5)
    channel = client.channels["/chatter"]
    assert (channel["encoding"], channel["schemaName"]) == ("cdr", "std_msgs/msg/String")
    assert (channel["schemaEncoding"], channel["schema"]) == ("ros2msg", "string data\n")
    message = STRING(data="hello")
    publisher.publish(message)
    number, stamp, payload = client.message()
    assert (number, payload) == (5, bytes(serialize(message)))
    assert stamp > 1_700_000_000_000_000_000


def test_a_definition_brings_those_of_the_types_in_it(ros, client):
    ros.node.create_publisher(get_message("geometry_msgs/msg/PoseStamped"), "/pose", 1)
    channel = client.until(lambda: client.channels.get("/pose"))
    for part in ("MSG: std_msgs/Header", "MSG: geometry_msgs/Quaternion", "float64 w"):
        assert part in channel["schema"]


def test_a_topic_is_listened_to_while_somebody_looks_at_it(ros, client):
    publisher = publisher_of(ros, "/chatter")
    client.until(lambda: client.channels.get("/chatter"))
    assert publisher.get_subscription_count() == 0
    client.subscribe("/chatter", 1)
    eventually(lambda: publisher.get_subscription_count() == 1)
    client.send("unsubscribe", subscriptionIds=[1])
    eventually(lambda: publisher.get_subscription_count() == 0)


def test_every_client_gets_what_is_latched(ros):
    publisher_of(ros, "/description", qos_profile_latched).publish(STRING(data="robot"))
    _, port = start(ros)
    with FoxgloveClient(port) as first, FoxgloveClient(port) as second:
        for client in (first, second):
            client.subscribe("/description", 1)
            assert deserialize(client.message()[2], STRING).data == "robot"


def test_a_topic_that_is_gone_is_withdrawn(ros, client):
    publisher = publisher_of(ros, "/chatter")
    client.until(lambda: client.channels.get("/chatter"))
    ros.node.destroy_publisher(publisher)
    client.until(lambda: "/chatter" not in client.channels)


@pytest.mark.parametrize(
    ("encoding", "data"),
    [("cdr", bytes(serialize(STRING(data="from afar")))), ("json", b'{"data": "from afar"}')],
)
def test_what_a_client_publishes_reaches_the_graph(ros, client, encoding, data):
    received = []
    got = threading.Event()

    def hear(message):
        received.append(message.data)
        got.set()

    ros.node.create_subscription(STRING, "/orders", hear, QoSProfile(depth=10), immediate=True)
    channel = {"id": 3, "topic": "/orders", "encoding": encoding, "schemaName": STRING.TYPE_NAME}
    client.send("advertise", channels=[channel])
    eventually(lambda: ros.node.count_publishers("/orders") == 1)
    client.send_binary(1, struct.pack("<I", 3) + data)
    assert got.wait(10.0)
    assert received == ["from afar"]
    client.send("unadvertise", channelIds=[3])
    eventually(lambda: ros.node.count_publishers("/orders") == 0)


def test_a_client_is_told_why_it_may_not_publish(ros):
    _, port = start(ros, "client_topic_whitelist:=['/allowed']")
    with FoxgloveClient(port) as client:
        channel = {"topic": "/cmd_vel", "encoding": "cdr", "schemaName": STRING.TYPE_NAME}
        client.send("advertise", channels=[{"id": 1, **channel}])
        assert "may not publish '/cmd_vel'" in client.document("status")["message"]
        client.send_binary(1, struct.pack("<I", 1) + b"\0\1\0\0")
        client.send("advertise", channels=[{"id": 2, **channel, "topic": "/allowed"}])
        eventually(lambda: ros.node.count_publishers("/allowed") == 1)
        assert ros.node.count_publishers("/cmd_vel") == 0


def test_clients_may_be_allowed_to_look_only(ros):
    _, port = start(ros, "capabilities:=[connectionGraph]")
    publisher_of(ros, "/chatter")
    with FoxgloveClient(port) as client:
        channel = {"topic": "/cmd_vel", "encoding": "cdr", "schemaName": STRING.TYPE_NAME}
        client.send("advertise", channels=[{"id": 1, **channel}])
        assert "clientPublish" in client.document("status")["message"]
        client.until(lambda: client.channels.get("/chatter"))
        assert client.services == {}
        assert ros.node.count_publishers("/cmd_vel") == 0


def test_services_are_offered_and_called(ros, client):
    kind = get_service("std_srvs/srv/SetBool")

    def answer(request, response):
        response.success, response.message = True, f"is {request.data}"
        return response

    ros.node.create_service(kind, "/switch", answer, immediate=True)
    service = client.until(lambda: client.services.get("/switch"))
    assert service["type"] == "std_srvs/srv/SetBool"
    assert service["request"]["schema"].startswith("bool data")
    client.call("/switch", bytes(serialize(kind.Request(data=True))))
    data = client.binary(SERVICE_RESPONSE)
    _, call, length = struct.unpack_from("<III", data)
    assert (call, data[12 : 12 + length]) == (7, b"cdr")
    assert deserialize(data[12 + length :], kind.Response).message == "is True"
    client.call("/switch", b"nonsense")
    assert "SetBool" in client.document("serviceCallFailure", callId=7)["message"]


def test_parameters_are_read_set_and_followed(ros, client):
    ros.spawn("run teleop_py_pkg simple_parameter")
    knows_parameters_of(client, "/simple_parameter")
    name = "/simple_parameter.simple_int_param"
    client.send("getParameters", parameterNames=[], id="all")
    answer = client.document("parameterValues", id="all")["parameters"]
    values = {p["name"]: p["value"] for p in answer}
    assert values[name] == 28
    assert values["/foxglove_bridge.port"] == 0
    client.send("subscribeParameterUpdates", parameterNames=[name])
    ros.node.wait_for_subscribers("/parameter_events", 1, LONGEST_WAIT_S)
    client.send("setParameters", parameters=[{"name": name, "value": 30}], id="set")
    answer = client.document("parameterValues", id="set")["parameters"]
    assert [(p["name"], p["value"]) for p in answer] == [(name, 30)]
    assert (
        ros.run("param get /simple_parameter simple_int_param").stdout == "Integer value is: 30\n"
    )
    ros.run("param set /simple_parameter simple_int_param 31")

    def told():
        return [p for d in client.documents for p in d.get("parameters", []) if p["value"] == 31]

    assert client.until(told)[0]["name"] == name


def test_a_whole_number_stays_a_double_where_the_node_has_one(ros, client):
    ros.node.declare_parameter("gain", 1.5)
    knows_parameters_of(client, ros.node.get_fully_qualified_name())
    name = f"{ros.node.get_fully_qualified_name()}.gain"
    client.send("setParameters", parameters=[{"name": name, "value": 2}], id="set")
    (parameter,) = client.document("parameterValues", id="set")["parameters"]
    assert (parameter["value"], parameter["type"]) == (2.0, "float64")


def test_meshes_of_packages_are_served_and_nothing_else(ros, client):
    (mesh,) = sorted(package_share("teleop_description").glob("meshes/*.STL"))[:1]
    uri = f"package://teleop_description/{mesh.relative_to(package_share('teleop_description'))}"
    wishes = [
        uri,
        "package://teleop_description/package.xml",
        "package://teleop_description/%2e%2e/pyproject.urdf",
        "file:///etc/passwd",
    ]
    answers = []
    for number, wish in enumerate(wishes):
        client.send("fetchAsset", uri=wish, requestId=number)
        data = client.binary(ASSET)
        request, status, length = struct.unpack_from("<IBI", data)
        assert request == number
        answers.append((status, data[9 + length :]))
    assert answers[0] == (0, mesh.read_bytes())
    assert [status for status, _ in answers[1:]] == [1, 1, 1]


def test_clients_see_who_is_connected_to_what(ros, client):
    publisher_of(ros, "/chatter")
    client.send("subscribeConnectionGraph")

    def publishers():
        for document in client.documents:
            for topic in document.get("publishedTopics", []):
                if topic["name"] == "/chatter":
                    return topic["publisherIds"]
        return None

    assert client.until(publishers) == [ros.node.get_fully_qualified_name()]


def test_simulated_time_is_told(ros):
    _, port = start(ros, "use_sim_time:=true")
    clock = get_message("rosgraph_msgs/msg/Clock")
    publisher = ros.node.create_publisher(clock, "/clock", 10)
    message = clock()
    message.clock.sec = 42
    with FoxgloveClient(port) as client:
        client.until(lambda: client.info)
        assert "time" in client.info["capabilities"]
        eventually(lambda: publisher.get_subscription_count() > 0)
        publisher.publish(message)
        assert struct.unpack("<Q", client.binary(TIME)) == (42_000_000_000,)


def test_whitelists_hide_topics_and_services(ros):
    _, port = start(ros, "topic_whitelist:=['/chat.*']", "service_whitelist:=['/none']")
    publisher_of(ros, "/other")
    publisher_of(ros, "/chatter")
    with FoxgloveClient(port) as client:
        client.until(lambda: client.channels.get("/chatter"))
        assert list(client.channels) == ["/chatter"]
        assert client.services == {}


@pytest.mark.parametrize(
    ("option", "text"),
    sample(
        [
            ("topic_whitelist:=['(']", "is not a regular expression"),
            ("capabilities:=[telepathy]", "capabilities"),
            ("tls:=true", "certfile"),
            ("port:=70000", "70000"),
        ],
        2,
    ),
)
def test_a_wrong_parameter_is_named(ros, option, text):
    done = ros.run(["run", "foxglove_bridge", "foxglove_bridge", "--ros-args", "-p", option])
    assert done.returncode == 1
    assert text in done.stderr
    assert "Traceback" not in done.stderr


def test_a_port_that_is_taken_is_named(ros):
    _, port = start(ros)
    options = ["--ros-args", "-p", f"port:={port}"]
    done = ros.run(["run", "foxglove_bridge", "foxglove_bridge", *options])
    assert done.returncode == 1
    assert f"127.0.0.1:{port}" in done.stderr
    assert "Traceback" not in done.stderr
