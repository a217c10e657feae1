"""Which nodes and topics stand in the picture of a graph: as rqt_graph decides."""

from teleopctl.diagram import ros_graph
from teleopctl.wire import EndpointQos, EndpointToken, EntityKind, Graph, NodeToken


def graph_of(*ends, nodes=()):
    """A graph of ``"/node > /topic"`` for publishers and ``"/node < /topic"`` for subscriptions."""
    tokens: list[NodeToken | EndpointToken] = [
        NodeToken(0, "z", 0, "/", "/", name) for name in nodes
    ]
    for number, end in enumerate(ends):
        node, sign, topic = end.split()
        kind = EntityKind.MP if sign == ">" else EntityKind.MS
        tokens.append(
            EndpointToken(
                *(0, "z", 0, number, kind, "/", "/", node.removeprefix("/"), topic),
                *("std_msgs/msg/String", "RIHS01_0", EndpointQos()),
            )
        )
    return Graph(tokens)


def shown(diagram):
    """The arrows with the texts of their boxes."""
    texts = {box.key: box.text for box in diagram.boxes}
    return {(texts[edge.source], texts[edge.target]) for edge in diagram.edges}


def names(diagram):
    return {box.text for box in diagram.boxes}


TALK = ("/talker > /chatter", "/listener < /chatter")


def test_topics_stand_between_the_nodes_that_they_join():
    diagram = ros_graph(graph_of(*TALK))
    assert shown(diagram) == {("/talker", "/chatter"), ("/chatter", "/listener")}
    assert {box.kind for box in diagram.boxes} == {"node", "topic"}


def test_only_all_shows_what_joins_nothing():
    graph = graph_of(*TALK, "/talker > /unheard", "/listener < /unsaid", nodes=("alone",))
    assert names(ros_graph(graph)) == {"/talker", "/chatter", "/listener"}
    everything = {"/talker", "/chatter", "/listener", "/unheard", "/unsaid", "/alone"}
    assert names(ros_graph(graph, "all")) == everything


def test_nodes_alone_have_the_topics_beside_their_arrows():
    graph = graph_of(*TALK, nodes=("alone",))
    diagram = ros_graph(graph, "nodes")
    assert shown(diagram) == {("/talker", "/chatter"), ("/chatter", "/listener")}
    assert {box.text: box.kind for box in diagram.boxes} == {
        "/talker": "node",
        "/listener": "node",
        "/alone": "node",
        "/chatter": "label",
    }


def test_several_topics_between_two_nodes_are_one_arrow_and_many_are_counted():
    few = graph_of(*(f"/a > /t{n}" for n in range(3)), *(f"/b < /t{n}" for n in range(3)))
    assert shown(ros_graph(few, "nodes")) == {("/a", "/t0\n/t1\n/t2"), ("/t0\n/t1\n/t2", "/b")}
    many = graph_of(*(f"/a > /t{n}" for n in range(9)), *(f"/b < /t{n}" for n in range(9)))
    assert shown(ros_graph(many, "nodes")) == {("/a", "9 topics"), ("9 topics", "/b")}


def test_what_every_node_has_and_what_only_watches_is_hidden():
    graph = graph_of(
        *TALK,
        "/talker > /rosout",
        "/rviz < /rosout",
        "/rviz < /chatter",
        "/_echo < /chatter",
        "/sim > /clock",
        "/talker < /clock",
        "/talker > /_hidden/x",
        "/listener < /_hidden/x",
    )
    assert names(ros_graph(graph)) == {"/talker", "/chatter", "/listener"}
    assert {"/rosout", "/rviz", "/_echo", "/clock", "/_hidden/x"} <= names(
        ros_graph(graph, include_hidden=True)
    )


def test_topics_that_belong_together_are_one():
    graph = graph_of(
        *("/a > /move/_action/status", "/a > /move/_action/feedback"),
        *("/b < /move/_action/status", "/b < /move/_action/feedback"),
        *("/cam > /image", "/cam > /image/compressed", "/b < /image/compressed", "/b < /image"),
        *("/a > /tf", "/a > /tf_static", "/b < /tf", "/b < /tf_static"),
    )
    assert names(ros_graph(graph)) == {
        *("/a", "/b", "/cam", "/move/action_topics", "/image/image_topics", "/tf")
    }


def test_a_node_with_the_name_of_a_topic_is_another_box():
    diagram = ros_graph(graph_of("/a > /x", "/x < /x"))
    assert [box.text for box in diagram.boxes] == ["/a", "/x", "/x"]


def test_a_node_that_hears_itself_stands_in_the_picture():
    graph = graph_of("/a > /x", "/a < /x")
    (edge,) = ros_graph(graph).edges
    assert edge.both
    (edge,) = ros_graph(graph, "nodes").edges
    assert edge.both
