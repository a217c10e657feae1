"""``teleopctl graph``: who talks to whom."""

import json

import pytest

from teleopctl.interfaces import get_message

String = get_message("std_msgs/msg/String")


@pytest.fixture
def talking(shared_ros):
    """A graph in which a node hears itself."""
    node = shared_ros.node
    publisher = node.create_publisher(String, "/chatter", 10)
    subscription = node.create_subscription(String, "/chatter", lambda _message: None, 10)
    node.context.wait_for_graph(lambda graph: graph.subscriptions("/chatter"), 10)
    yield shared_ros
    node.destroy_publisher(publisher)
    node.destroy_subscription(subscription)


def test_it_is_printed_for_graphviz(talking):
    lines = talking.run("graph").stdout.splitlines()
    assert (lines[0], lines[-1]) == ("digraph graph_of_nodes {", "}")
    assert '  "node /test" -> "topic /chatter" [dir=both];' in lines
    assert talking.run("graph --dot").stdout.splitlines() == lines


def test_it_is_drawn_to_a_file(talking, tmp_path):
    file = tmp_path / "graph.svg"
    assert talking.run(["graph", "--svg", str(file)]).stdout == f"{file}: 2 boxes, 1 arrows\n"
    text = file.read_text(encoding="utf-8")
    assert text.startswith("<svg ")
    assert ">/chatter</text>" in text
    failed = talking.run(["graph", "--svg", str(tmp_path / "no" / "graph.svg")])
    assert failed.returncode == 1
    assert "No such file or directory" in failed.stderr


def test_programs_get_boxes_and_arrows(talking):
    document = json.loads(talking.run("graph --show nodes --json").stdout)
    assert {"key": "node /test", "text": "/test", "kind": "node"} in document["boxes"]
    assert [edge["source"] for edge in document["edges"]] == ["label /test /test"] or document[
        "edges"
    ]


def test_hidden_things_are_drawn_when_asked_for(talking):
    assert "/rosout" not in talking.run("graph --show all").stdout
    assert "/rosout" in talking.run("graph --show all --include-hidden").stdout


def test_one_form_at_a_time(ros_without_router):
    assert ros_without_router.run("graph --dot --json").returncode == 2
    assert ros_without_router.run("graph --show some").returncode == 2
