"""Names in the graph may hold anything; no verb lets their control characters through."""

import json
import re
from collections.abc import Iterator

import pytest

from teleopctl.interfaces import get_message, get_service
from teleopctl.testing import RosGraph
from teleopctl.wire.qos import EndpointQos
from teleopctl.wire.session import open_session
from teleopctl.wire.tokens import EndpointToken, EntityKind, NodeToken, format_token
from tests.samples import sample

EVIL = "evil\x1b[31m\x07\nINJECTED\r\x9b2J\u202e"
SHOWN = r"evil\x1b[31m\x07\nINJECTED\r\x9b2J\u202e"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e]")
NO_TYPE = "TypeHashNotSupported"


@pytest.fixture(scope="module")
def hostile(shared_ros: RosGraph) -> Iterator[RosGraph]:
    """A graph with tokens of another implementation, and a node that says evil things."""
    domain = shared_ros.domain
    with open_session("peer") as session:
        zid = str(session.zid())
        tokens: list[NodeToken | EndpointToken] = [NodeToken(domain, zid, 0, "/", "/", EVIL)]
        for number, (kind, type_name) in enumerate(
            [
                (EntityKind.MP, "std_msgs/msg/String"),
                (EntityKind.MS, f"std_msgs/msg/{EVIL}"),
                (EntityKind.SS, "std_srvs/srv/Trigger"),
                (EntityKind.SC, f"std_srvs/srv/{EVIL}"),
            ],
            start=1,
        ):
            qos = EndpointQos(depth=1)
            name = f"/{EVIL}"
            tokens.append(
                EndpointToken(
                    *(domain, zid, 0, number, kind, "/", "/", EVIL, name, type_name, NO_TYPE, qos)
                )
            )
        held = [session.liveliness().declare_token(format_token(token)) for token in tokens]
        shared_ros.node.declare_parameter(EVIL, EVIL)
        publisher = shared_ros.node.create_publisher(
            get_message("std_msgs/msg/String"), "/words", 10
        )
        shared_ros.node.create_timer(0.05, lambda: publisher.publish(publisher.msg_type(data=EVIL)))
        shared_ros.node.create_service(
            get_service("std_srvs/srv/Trigger"), "/ask", lambda _, answer: _told(answer)
        )
        yield shared_ros
        del held


def _told(answer):
    answer.message = EVIL
    return answer


NAME = f"/{SHOWN}"


@pytest.mark.parametrize(
    "words",
    sample(
        [
            ["topic", "list", "-t"],
            ["topic", "list", "-v"],
            ["topic", "list", "--json"],
            ["topic", "info", NAME],
            ["topic", "info", NAME, "--verbose"],
            ["topic", "info", NAME, "--verbose", "--json"],
            ["topic", "type", NAME],
            ["topic", "find", "std_msgs/msg/String"],
            ["topic", "echo", NAME, "--once", "--timeout", "0.1"],
            ["topic", "echo", "/words", "--once"],
            ["topic", "echo", "/words", "--once", "--csv"],
            ["topic", "echo", "/words", "--once", "--json"],
            ["topic", "echo", "/words", "--once", "--field", "data"],
            ["topic", "pub", "--once", NAME, "std_msgs/msg/String", "--max-wait-time-secs", "0.1"],
            ["node", "list"],
            ["node", "list", "--json"],
            ["node", "info", NAME],
            ["node", "info", NAME, "--json"],
            ["service", "list", "-t"],
            ["service", "list", "--json"],
            ["service", "type", NAME],
            ["service", "find", "std_srvs/srv/Trigger"],
            ["service", "call", "/ask", "std_srvs/srv/Trigger"],
            ["service", "call", "/ask", "std_srvs/srv/Trigger", "--json"],
            ["service", "call", NAME, "std_srvs/srv/Trigger", "--timeout", "0.1"],
            ["param", "list", "OBSERVER"],
            ["param", "list", "OBSERVER", "--json"],
            ["param", "dump", "OBSERVER"],
            ["param", "get", "OBSERVER", EVIL],
            ["param", "describe", "OBSERVER", EVIL],
            ["param", "list", NAME],
            ["control", "list_controllers", "-c", NAME],
            ["tf", "echo", "--once", EVIL, "world"],
        ],
        3,
    ),
    ids=lambda words: " ".join(words).replace(NAME, "EVIL").replace(EVIL, "EVIL"),
)
def test_no_verb_lets_control_characters_through(hostile, words):
    observer = hostile.node.get_fully_qualified_name()
    words = [observer if word == "OBSERVER" else word for word in words]
    program = hostile.spawn(words)
    if words[0] == "tf":
        program.wait_for_line("Waiting for transform")
        program.interrupt()
    program.wait()
    output = program.stdout + program.stderr
    assert "INJECTED" in output
    assert not CONTROL.search(output), output
    # But for a text that is printed as it is, line breaks are visible too.
    is_text = words[:2] == ["param", "get"] or "--field" in words
    assert is_text or not re.search("^INJECTED", output, re.MULTILINE)
    assert "Traceback" not in output
    if "--json" in words:
        is_stream = words[1] in ("echo", "call")
        for document in program.stdout.splitlines() if is_stream else [program.stdout]:
            json.loads(document)


def test_a_log_line_shows_the_control_characters_of_its_message(ros, tmp_path):
    file = tmp_path / "evil.py"
    file.write_text(
        "import rclpy\n"
        "rclpy.init()\n"
        f"rclpy.create_node('me').get_logger().info({'a[31m' + EVIL!r})\n",
        encoding="utf-8",
    )
    done = ros.run(["run", str(file)])
    assert r"\x07" in done.stderr
    assert not CONTROL.search(re.sub("\x1b\\[[0-9;]*m", "", done.stderr)), done.stderr
