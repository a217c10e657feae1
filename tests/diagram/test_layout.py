"""The layout of a diagram: nothing overlaps, arrows join their boxes and lead to the right."""

import pytest
from hypothesis import given, strategies

from teleopctl.diagram import DiagramBox, lay_out, ros_graph, to_svg
from teleopctl.diagram.layout import assign_columns, connect, order_columns
from teleopctl.wire import Graph

numbers = strategies.integers(0, 11)
pairs_of_numbers = strategies.lists(strategies.tuples(numbers, numbers), max_size=40)
texts = strategies.lists(strategies.text(min_size=1, max_size=40), min_size=12, max_size=12)


def diagram_of(pairs, texts=("/name",) * 12):
    boxes = [DiagramBox(str(number), text, "node") for number, text in enumerate(texts)]
    return connect(boxes, [(str(first), str(last)) for first, last in pairs])


@given(pairs_of_numbers, texts)
def test_no_box_overlaps_another_one_and_all_are_in_the_picture(pairs, texts):
    layout = lay_out(diagram_of(pairs, texts))
    places = list(layout.places.values())
    for place in places:
        assert place.x >= 0
        assert place.y >= 0
        assert place.x + place.width <= layout.width
        assert place.y + place.height <= layout.height
    for index, one in enumerate(places):
        for other in places[index + 1 :]:
            assert (
                one.x + one.width <= other.x
                or other.x + other.width <= one.x
                or one.y + one.height <= other.y + 1e-6
                or other.y + other.height <= one.y + 1e-6
            )


@given(pairs_of_numbers)
def test_every_arrow_goes_from_the_edge_of_its_source_to_that_of_its_target(pairs):
    diagram = diagram_of(pairs)
    layout = lay_out(diagram)
    for edge, route in zip(diagram.edges, layout.routes, strict=True):
        for key, (x, y) in ((edge.source, route[0]), (edge.target, route[-1])):
            place = layout.places[key]
            assert any(x == pytest.approx(end) for end in (place.x, place.x + place.width))
            assert place.y <= y <= place.y + place.height


@given(pairs_of_numbers)
def test_without_circles_every_arrow_leads_to_the_right(pairs):
    diagram = diagram_of([pair for pair in pairs if pair[0] < pair[1]])
    layout = lay_out(diagram)
    for edge in diagram.edges:
        source, target = layout.places[edge.source], layout.places[edge.target]
        assert source.x + source.width < target.x


@given(pairs_of_numbers)
def test_an_arrow_passes_through_one_place_of_each_column_between(pairs):
    columns, chains = assign_columns(12, pairs)
    column_of = {number: index for index, column in enumerate(columns) for number in column}
    assert sorted(column_of) == list(range(len(column_of)))
    for (first, last), chain in zip(pairs, chains, strict=True):
        assert {chain[0], chain[-1]} == {first, last}
        at = [column_of[number] for number in chain]
        assert at == list(range(at[0], at[0] + len(at)))
    ordered = order_columns(columns, chains)
    assert [sorted(column) for column in ordered] == [sorted(column) for column in columns]


def test_arrows_that_can_do_without_crossing_do():
    diagram = diagram_of([(0, 5), (1, 4), (2, 3)])
    places = lay_out(diagram).places
    heights = [(places[str(a)].y, places[str(b)].y) for a, b in ((0, 5), (1, 4), (2, 3))]
    by_source = sorted(heights)
    assert [target for _, target in by_source] == sorted(target for _, target in heights)


def test_a_chain_is_a_straight_line():
    layout = lay_out(diagram_of([(0, 1), (1, 2), (2, 3)]))
    chain = [layout.places[str(number)] for number in range(4)]
    assert len({round(place.y, 3) for place in chain}) == 1


def test_there_and_back_is_one_arrow_with_two_heads():
    (edge,) = diagram_of([(0, 1), (1, 0), (0, 1)]).edges
    assert edge.both


@given(pairs_of_numbers)
def test_the_same_diagram_has_the_same_picture(pairs):
    assert to_svg(diagram_of(pairs)) == to_svg(diagram_of(pairs))


def test_a_graph_without_nodes_is_an_empty_picture():
    assert lay_out(ros_graph(Graph())).places == {}
    assert "<svg" in to_svg(ros_graph(Graph()))
