"""Interactive markers: the state of a server's, what is sent to browsers, and what people do."""

from __future__ import annotations

import asyncio
import itertools
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_message, get_service
from teleopctl.tf import Transform, quaternion_from_rpy
from teleopctl.viewer import OK, WARN
from teleopctl.viewer.displays.markers.interactive import UpdateSequence
from teleopctl.viewer.displays.markers.interactive_marker import selectable_entries
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, Draw, Picture, look, put_frame
from tests.viewer.displays.test_geometry import pose
from tests.viewer.displays.test_markers import marker

InteractiveMarker = get_message("visualization_msgs/msg/InteractiveMarker")
Control = get_message("visualization_msgs/msg/InteractiveMarkerControl")
Update = get_message("visualization_msgs/msg/InteractiveMarkerUpdate")
MarkerPose = get_message("visualization_msgs/msg/InteractiveMarkerPose")
MenuEntry = get_message("visualization_msgs/msg/MenuEntry")
Feedback = get_message("visualization_msgs/msg/InteractiveMarkerFeedback")
State = get_service("visualization_msgs/srv/GetInteractiveMarkers").Response
QUARTER = quaternion_from_rpy(0.0, 0.0, math.pi / 2)


class Server:
    """A server of interactive markers, played by the test, and the topic of feedback."""

    def __init__(self, page: FakePage) -> None:
        self.feedback: list[Any] = []
        self.requests: list[Callable[[Any], object]] = []
        self.is_there = True
        client = SimpleNamespace(
            srv_name="/demo/get_interactive_markers",
            service_is_ready=lambda: self.is_there,
            call_async=lambda _request: SimpleNamespace(add_done_callback=self.requests.append),
        )
        page.node.create_client = lambda _kind, name: self._named(client, name)
        page.node.create_publisher = lambda _kind, name, _depth: self._named(
            SimpleNamespace(publish=self.feedback.append), name
        )
        page.node.destroy_client = page.node.destroy_publisher = lambda _which: True
        self.names: list[str] = []

    def _named(self, endpoint: Any, name: str) -> Any:
        self.names.append(name)
        return endpoint

    def answer(self, number: int, *markers: Any) -> None:
        """Answer the oldest request for the full state."""
        state = State(sequence_number=number, markers=list(markers))
        done = SimpleNamespace(exception=lambda: None, result=lambda: state)
        self.requests.pop(0)(done)

    def said(self) -> list[tuple[int, str]]:
        """The kinds of feedback, and the controls."""
        return [(each.event_type, each.control_name) for each in self.feedback]


@pytest.fixture
def server(page: FakePage) -> Server:
    """A server on the page's graph."""
    return Server(page)


def interactive(name: str = "m", *controls: Any, frame: str = "map", **fields: Any) -> Any:
    made = InteractiveMarker(name=name, controls=list(controls), scale=0.5, pose=pose(1.0, 0.0))
    made.header.frame_id = frame
    for key, value in fields.items():
        setattr(made, key, value)
    return made


def control(mode: int, name: str = "c", *markers: Any, turn: Any = (0.0, 0.0, 0.0, 1.0)) -> Any:
    made = Control(name=name, interaction_mode=mode, markers=list(markers))
    (made.orientation.x, made.orientation.y, made.orientation.z, made.orientation.w) = turn
    return made


def gizmos(page: FakePage) -> list[Any]:
    scene: Any = page.scene
    return [
        node
        for node in scene._handle_from_node_name.values()
        if type(node).__name__ == "TransformControlsHandle"
    ]


def drag(gizmo: Any, *places: tuple[float, float, float]) -> None:
    """Take a gizmo, move it, and let go."""

    def happen(phase: str) -> None:
        event = SimpleNamespace(phase=phase, target=gizmo)
        for callback in gizmo._impl_aux.update_cb:
            asyncio.run(callback(event))

    happen("start")
    for place in places:
        gizmo._impl.position = np.array(place)
        happen("update")
    happen("end")


def begin(page: FakePage, draw: Draw, server: Server, *markers: Any, **given: Any) -> Any:
    display = draw("InteractiveMarkers", **{"Interactive Markers Namespace": "/demo"}, **given)
    look(page)
    server.answer(5, *markers)
    look(page)
    return display


def test_the_full_state_is_asked_for_and_updates_follow(page: FakePage, draw: Draw, server: Server):
    display = begin(page, draw, server, interactive("a"), interactive("b"))
    assert server.names == ["/demo/get_interactive_markers", "/demo/feedback"]
    assert set(display.markers) == {"a", "b"}
    assert display.status == (OK, "")
    page.publish("/demo/update", Update(seq_num=6, type=Update.UPDATE, erases=["a"]))
    moved = MarkerPose(name="b", pose=pose(3.0, 0.0))
    moved.header.frame_id = "map"
    page.publish("/demo/update", Update(seq_num=7, type=Update.UPDATE, poses=[moved]))
    look(page)
    assert set(display.markers) == {"b"}
    assert display.markers["b"].pose.translation == (3.0, 0.0, 0.0)
    assert not server.requests


def test_a_gap_in_the_updates_asks_for_the_full_state_again(
    page: FakePage, draw: Draw, server: Server, monkeypatch: pytest.MonkeyPatch
):
    clock = itertools.count(1000.0, 10.0)
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    display = begin(page, draw, server, interactive("a"))
    page.publish("/demo/update", Update(seq_num=9, type=Update.UPDATE, erases=["a"]))
    look(page)
    assert len(server.requests) == 1
    server.answer(8, interactive("a"), interactive("z"))
    # the update that revealed the gap came after that state
    assert set(display.markers) == {"z"}


def test_without_a_server_the_status_says_what_is_missing(
    page: FakePage, draw: Draw, server: Server
):
    server.is_there = False
    display = draw("InteractiveMarkers", **{"Update Topic": "/demo/update"})
    look(page)
    assert display.status == (WARN, "No node offers /demo/get_interactive_markers")


def test_dragging_an_axis_tells_the_server_and_moves_the_marker(
    page: FakePage, draw: Draw, server: Server, picture: Picture
):
    look_of_it = marker(1, frame="", scale=(0.1, 0.1, 0.1))
    display = begin(
        page,
        draw,
        server,
        interactive("m", control(Control.MOVE_AXIS, "along", look_of_it), description="Move me"),
    )
    (gizmo,) = gizmos(page)
    assert (gizmo.active_axes, gizmo.disable_rotations) == ((True, False, False), True)
    assert gizmo.position.tolist() == [1.0, 0.0, 0.0]
    drag(gizmo, (1.5, 0.0, 0.0), (2.0, 0.0, 0.0))
    assert server.said() == [
        (Feedback.MOUSE_DOWN, "along"),
        (Feedback.POSE_UPDATE, "along"),
        (Feedback.POSE_UPDATE, "along"),
        (Feedback.MOUSE_UP, "along"),
    ]
    last = server.feedback[-1]
    assert (last.marker_name, last.header.frame_id) == ("m", "map")
    assert last.client_id == server.feedback[0].client_id != ""
    assert (last.pose.position.x, last.pose.orientation.w) == (2.0, 1.0)
    assert display.markers["m"].pose.translation == (2.0, 0.0, 0.0)
    nodes = picture.nodes("/frames/map/display1/marker1")
    assert set(nodes) == {"handle0", "body/control0/box", "body/description"}


def test_a_turned_control_acts_along_its_own_axis(page: FakePage, draw: Draw, server: Server):
    s, c = math.sin(0.2), math.cos(0.2)
    controls = [
        control(Control.MOVE_AXIS, "y", turn=QUARTER),
        control(Control.ROTATE_AXIS, "about y", turn=QUARTER),
        control(Control.MOVE_PLANE, "plane"),
        control(Control.MOVE_ROTATE_3D, "all"),
        control(Control.MOVE_AXIS, "slanting", turn=(0.0, 0.0, s, c)),
    ]
    begin(page, draw, server, interactive("m", *controls))
    y, about, plane, everything, slant = gizmos(page)
    # along an axis of the marker, which has its own colour
    assert y.active_axes == (False, True, False)
    assert about.active_axes == (True, False, True)
    assert (about.disable_rotations, about.disable_axes) == (False, True)
    assert (plane.disable_sliders, plane.disable_rotations) == (False, True)
    assert everything.active_axes == (True, True, True)
    np.testing.assert_allclose(slant.wxyz, [c, 0.0, 0.0, s], atol=1e-9)
    assert slant.active_axes == (True, False, False)
    drag(slant, (1.0, 2.0, 0.0))
    # the marker itself is not turned, and its other handles have come along
    assert server.feedback[-1].pose.orientation.w == pytest.approx(1.0)
    assert plane.position.tolist() == [1.0, 2.0, 0.0]


def test_while_a_marker_is_held_the_server_cannot_take_it_away(
    page: FakePage, draw: Draw, server: Server
):
    display = begin(page, draw, server, interactive("m", control(Control.MOVE_AXIS)))
    (gizmo,) = gizmos(page)
    held = display.markers["m"]
    event = SimpleNamespace(phase="start", target=gizmo)
    asyncio.run(gizmo._impl_aux.update_cb[0](event))
    again = interactive("m", control(Control.MOVE_AXIS), pose=pose(9.0, 0.0))
    page.publish("/demo/update", Update(seq_num=6, type=Update.UPDATE, markers=[again]))
    assert display.markers["m"] is held
    event.phase = "end"
    asyncio.run(gizmo._impl_aux.update_cb[0](event))
    assert display.markers["m"].pose.translation == (9.0, 0.0, 0.0)


def test_a_click_on_a_button_and_a_choice_of_a_menu_are_told(
    page: FakePage, draw: Draw, server: Server, picture: Picture
):
    button = control(Control.BUTTON, "press", marker(1, frame=""))
    menu = control(Control.MENU, "menu", marker(2, frame="", scale=(0.2, 0.2, 0.2)))
    entries = [
        MenuEntry(id=1, title="Tools"),
        MenuEntry(id=2, parent_id=1, title="Open", command="rm -rf /", command_type=1),
    ]
    display = begin(page, draw, server, interactive("m", button, menu, menu_entries=entries))
    nodes = picture.nodes("/frames/map/display1/marker1")

    def click(node: Any) -> None:
        for entry in node._impl.click_cb:
            client = SimpleNamespace(gui=page.gui)
            entry.callback(SimpleNamespace(target=node, client=client))

    click(nodes["body/control0/box0"])
    assert server.said() == [
        (Feedback.MOUSE_DOWN, "press"),
        (Feedback.BUTTON_CLICK, "press"),
        (Feedback.MOUSE_UP, "press"),
    ]
    server.feedback.clear()
    click(nodes["body/control1/sphere0"])
    container = display.markers["m"]._menu
    choice, close = container._children.values()
    assert (choice.label, close.label) == ("Tools > Open", "Close")
    page.click(choice)
    (told,) = server.feedback
    assert (told.event_type, told.menu_entry_id) == (Feedback.MENU_SELECT, 2)
    assert display.markers["m"]._menu is None


def test_a_marker_without_a_time_moves_with_its_frame_and_one_with_a_time_stands(
    page: FakePage, draw: Draw, server: Server
):
    put_frame(page, "tool", "map", Transform((2.0, 0.0, 0.0)), SECOND)
    page.frames.update()
    stamped = interactive("stands", frame="tool")
    stamped.header.stamp.sec = 1
    display = begin(page, draw, server, interactive("moves", frame="tool"), stamped)
    assert display.markers["moves"]._place.name.startswith("/frames/tool/")
    assert display.markers["stands"]._place.position.tolist() == [2.0, 0.0, 0.0]


def test_nothing_is_left_when_the_display_ends(
    page: FakePage, draw: Draw, server: Server, picture: Picture
):
    display = begin(page, draw, server, interactive("m", control(Control.MOVE_ROTATE_3D)))
    display.end()
    assert not display.markers
    assert not picture.nodes("/frames/map/display1")
    assert not gizmos(page)


def test_a_marker_that_is_not_finite_is_told_and_the_others_are_drawn(
    page: FakePage, draw: Draw, server: Server
):
    display = begin(
        page, draw, server, interactive("bad", pose=pose(math.nan, 0.0)), interactive("good")
    )
    assert set(display.markers) == {"good"}
    assert display.status == (WARN, "bad has numbers that are not finite")


def test_a_menu_whose_entries_stand_in_each_other_has_an_end():
    entries = [
        MenuEntry(id=1, parent_id=2, title="a"),
        MenuEntry(id=2, parent_id=1, title="b"),
        MenuEntry(id=3, parent_id=1, title="c\n"),
    ]
    ((number, title),) = selectable_entries(entries)
    assert number == 3
    assert title.isprintable()


@given(
    strategies.integers(0, 12),
    strategies.lists(strategies.integers(0, 12).map(lambda n: n), max_size=20),
)
def test_updates_apply_in_order_and_each_once(start: int, numbers: list[int]):
    feed = UpdateSequence()
    applied = [each.seq_num for each in feed.start(start)]
    last = start
    for number in numbers:
        if feed.add(Update(seq_num=number, type=Update.UPDATE)):
            applied.append(number)
            assert number == last + 1
            last = number
        if feed.needs_state:
            # whatever comes now waits for the full state, which has everything up to it
            applied_before = len(applied)
            applied += [each.seq_num for each in feed.start(number)]
            assert len(applied) == applied_before
            last = number
    assert not feed.needs_state
