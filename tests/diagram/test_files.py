"""A diagram as SVG and for Graphviz: names are text in both."""

from xml.etree import ElementTree

from hypothesis import given, strategies

from teleopctl.diagram import DiagramBox, format_dot, to_svg
from teleopctl.diagram.layout import connect

SVG = "{http://www.w3.org/2000/svg}"

# What a token of the graph may hold: control characters are visible by then.
names = strategies.text(
    strategies.characters(exclude_categories=["C"], include_characters="<>&\"'\\"), min_size=1
)


@given(names, names)
def test_a_picture_has_every_name_as_text(first, second):
    diagram = connect(
        [DiagramBox("a", first, "node"), DiagramBox("b", second, "topic")], [("a", "b")]
    )
    root = ElementTree.fromstring(to_svg(diagram))
    assert [text.text for text in root.iter(f"{SVG}text")] == [first, second]
    assert {element.tag.removeprefix(SVG) for element in root.iter()} == {
        *("svg", "path", "rect", "text")
    }


def test_a_label_has_no_frame_and_no_arrowhead():
    boxes = [
        DiagramBox("a", "/a", "node"),
        DiagramBox("l", "/x\n/y", "label"),
        DiagramBox("b", "/b", "node"),
    ]
    diagram = connect(boxes, [("a", "l"), ("l", "b")])
    svg = to_svg(diagram)
    assert svg.count("<rect") == 2
    assert svg.count("<path") == 3
    assert svg.count("<text") == 4
    assert '"a" -> "l" [dir=none];' in format_dot(diagram)


def test_graphviz_gets_names_in_quotes():
    diagram = connect(
        [DiagramBox("a", 'say "\\n"', "topic"), DiagramBox("b", "/b", "node")], [("a", "b")]
    )
    assert format_dot(diagram).splitlines() == [
        "digraph graph_of_nodes {",
        "  rankdir=LR;",
        '  "a" [label="say \\"\\\\n\\"", shape=box];',
        '  "b" [label="/b", shape=ellipse];',
        '  "a" -> "b";',
        "}",
    ]
