"""Controls of interactive markers: how they are turned, and what of them can be used."""

from __future__ import annotations

import asyncio
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.tf import Quaternion, Transform, quaternion_from_rpy
from teleopctl.viewer import OK
from teleopctl.viewer.displays.markers.interactive_control import ControlOrientation
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, Draw, Picture, look, put_frame
from tests.viewer.displays.test_geometry import pose
from tests.viewer.displays.test_interactive_markers import (
    Control,
    Feedback,
    Server,
    begin,
    control,
    gizmos,
    interactive,
    server,
)
from tests.viewer.displays.test_markers import marker

__all__ = ["server"]

HALF = quaternion_from_rpy(0.0, 0.0, math.pi)
QUARTER = quaternion_from_rpy(0.0, 0.0, math.pi / 2)
angles = strategies.floats(-3.0, 3.0)
rotations = strategies.builds(quaternion_from_rpy, angles, angles, angles)


def turned(mode: int, name: str = "c", *, independent: bool = False, turn: Any = None) -> Any:
    """A ring with a box, of an orientation mode."""
    made = control(
        Control.ROTATE_AXIS, name, marker(1, frame=""), turn=turn or (0.0, 0.0, 0.0, 1.0)
    )
    made.orientation_mode, made.independent_marker_orientation = mode, independent
    return made


def rotation_of(node: Any) -> Transform:
    w, x, y, z = (float(part) for part in node.wxyz)
    return Transform(rotation=(x, y, z, w))


def ahead(rotation: Transform) -> list[float]:
    return [round(part, 6) for part in (rotation @ Transform((1.0, 0.0, 0.0))).translation]


def node(page: FakePage, path: str) -> Any:
    found = page.scene.get_handle_by_name(path)
    assert found is not None, path
    return found


def twist(page: FakePage, gizmo: Any, angle: float) -> None:
    """Turn a ring about the gizmo's x axis, and let go."""

    def happen(phase: str) -> None:
        event = SimpleNamespace(phase=phase, target=gizmo)
        for callback in gizmo._impl_aux.update_cb:
            asyncio.run(callback(event))

    happen("start")
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    x, y, z, w = (rotation_of(gizmo) @ Transform(rotation=(s, 0.0, 0.0, c))).rotation
    gizmo._impl.wxyz = np.array((w, x, y, z))
    happen("update")
    happen("end")


def test_what_faces_the_viewer_is_turned_as_the_camera_moves(
    page: FakePage, draw: Draw, server: Server
):
    put_frame(page, "tool", "map", Transform((0.0, 0.0, 1.0), QUARTER), SECOND)
    controls = [
        turned(Control.VIEW_FACING, "both"),
        turned(Control.VIEW_FACING, "gizmo alone", independent=True),
    ]
    display = begin(
        page, draw, server, interactive("m", *controls, frame="tool", pose=pose(0, 0, turn=HALF))
    )
    place = "/frames/tool/display1/marker1"
    for view in (HALF, quaternion_from_rpy(0.1, 0.5, 1.0)):
        page.last_camera_pose = Transform((5.0, 0.0, 0.0), view)
        look(page)
        in_map = Transform(rotation=QUARTER)
        for gizmo in gizmos(page):
            assert ahead(in_map @ rotation_of(gizmo)) == ahead(Transform(rotation=view))
        own = rotation_of(node(page, f"{place}/control0"))
        np.testing.assert_allclose(np.abs(np.dot((in_map @ own).rotation, view)), 1.0, atol=1e-9)
    # its markers are turned as the interactive marker is
    assert ahead(rotation_of(node(page, f"{place}/body"))) == [-1, 0, 0]
    assert node(page, f"{place}/body/control1/box")
    assert display.status == (OK, "")


def test_a_viewer_who_stands_still_is_not_sent_anything(
    page: FakePage, draw: Draw, server: Server, monkeypatch: pytest.MonkeyPatch
):
    begin(page, draw, server, interactive("m", turned(Control.VIEW_FACING)))
    page.last_camera_pose = Transform((5.0, 0.0, 0.0), HALF)
    look(page)
    sent: list[object] = []
    monkeypatch.setattr(page.scene, "_queue_scene_message", sent.append)
    look(page)
    page.last_camera_pose = Transform((6.0, 1.0, 0.0), HALF)
    look(page)
    assert not sent


def test_a_gizmo_that_a_hand_holds_is_not_taken_from_it(page: FakePage, draw: Draw, server: Server):
    begin(page, draw, server, interactive("m", turned(Control.VIEW_FACING)))
    (gizmo,) = gizmos(page)
    asyncio.run(gizmo._impl_aux.update_cb[0](SimpleNamespace(phase="start", target=gizmo)))
    before = gizmo.wxyz.tolist()
    page.last_camera_pose = Transform((5.0, 0.0, 0.0), HALF)
    look(page)
    assert gizmo.wxyz.tolist() == before


def test_a_fixed_control_turns_with_the_hand_and_not_with_its_marker(
    page: FakePage, draw: Draw, server: Server
):
    about_z = quaternion_from_rpy(0.0, -math.pi / 2, 0.0)
    fixed = turned(Control.FIXED, "fixed", turn=about_z)
    display = begin(page, draw, server, interactive("m", fixed, pose=pose(0, 0, turn=QUARTER)))
    own = node(page, "/frames/map/display1/marker1/control0")
    assert ahead(rotation_of(own)) == [1, 0, 0]
    (gizmo,) = gizmos(page)
    # the third axis of the marker, whose own colour the ring has
    assert gizmo.active_axes == (True, True, False)
    drawn = display.markers["m"]
    drawn._controls[0].handle._dragged("start", rotation_of(gizmo))
    drawn._controls[0].handle._dragged("update", Transform(rotation=QUARTER))
    drawn._controls[0].handle._dragged("end", Transform(rotation=QUARTER))
    assert ahead(rotation_of(own)) == [0, 1, 0]
    assert ahead(Transform(rotation=drawn.pose.rotation)) == [-1, 0, 0]
    assert [kind for kind, _ in server.said()] == [
        Feedback.MOUSE_DOWN,
        Feedback.POSE_UPDATE,
        Feedback.MOUSE_UP,
    ]


def test_a_ring_that_faces_the_viewer_turns_its_marker_about_the_line_of_sight(
    page: FakePage, draw: Draw, server: Server
):
    display = begin(page, draw, server, interactive("m", turned(Control.VIEW_FACING)))
    page.last_camera_pose = Transform((0.0, 0.0, 5.0), quaternion_from_rpy(0.0, math.pi / 2, 0.0))
    look(page)
    (gizmo,) = gizmos(page)
    twist(page, gizmo, -math.pi / 2)  # about what lies ahead, which is down
    assert ahead(Transform(rotation=display.markers["m"].pose.rotation)) == [0, 1, 0]
    assert display.markers["m"]._controls[0].turning.angle == pytest.approx(-math.pi / 2)


@given(rotations, rotations, rotations, strategies.floats(-3.0, 3.0))
def test_a_control_that_faces_the_viewer_acts_along_the_line_of_sight_however_it_is_turned(
    own: Quaternion, view: Quaternion, marker_turn: Quaternion, angle: float
):
    turning = ControlOrientation(turned(Control.VIEW_FACING, turn=own))
    turning.face_camera(view)
    turning.angle = angle
    here = turning.pose_for(Transform((1.0, 2.0, 3.0), marker_turn))
    assert here.translation == (1.0, 2.0, 3.0)
    acts = Transform(rotation=here.rotation) @ turning.axes
    np.testing.assert_allclose(ahead(acts), ahead(Transform(rotation=view)), atol=1e-5)
    line = ahead(Transform(rotation=view))
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    again = Transform(rotation=(line[0] * s, line[1] * s, line[2] * s, c))
    assert turning.angle_of(again, Transform()) == pytest.approx(angle, abs=1e-4)


@pytest.mark.parametrize(
    ("mode", "axes", "arrows", "planes", "rings"),
    [
        (Control.MOVE_AXIS, (True, False, False), True, False, False),
        (Control.MOVE_PLANE, (False, True, True), False, True, False),
        (Control.ROTATE_AXIS, (False, True, True), False, False, True),
        (Control.MOVE_ROTATE, (False, True, True), False, True, True),
        (Control.MOVE_3D, (True, True, True), True, True, False),
        (Control.ROTATE_3D, (True, True, True), False, False, True),
        (Control.MOVE_ROTATE_3D, (True, True, True), True, True, True),
    ],
)
def test_each_kind_of_control_has_the_parts_that_it_can_be_taken_by(
    page: FakePage,
    draw: Draw,
    server: Server,
    mode: int,
    axes: tuple[bool, ...],
    arrows: bool,
    planes: bool,
    rings: bool,
):
    begin(page, draw, server, interactive("m", control(mode)))
    (gizmo,) = gizmos(page)
    parts = (gizmo.disable_axes, gizmo.disable_sliders, gizmo.disable_rotations)
    assert gizmo.active_axes == axes
    assert parts == (not arrows, not planes, not rings)


def test_a_menu_without_markers_is_opened_at_its_words(
    page: FakePage, draw: Draw, server: Server, picture: Picture
):
    menu = control(Control.MENU, "menu")
    menu.description = "Options"
    begin(page, draw, server, interactive("m", menu, control(Control.NONE, "none")))
    nodes = picture.nodes("/frames/map/display1/marker1/body/control0")
    assert nodes["text0"].text == "Options"
    (clicked,) = nodes["sphere0"]._impl.click_cb
    clicked.callback(SimpleNamespace(client=SimpleNamespace(gui=page.gui)))
    assert not gizmos(page)


def test_a_size_that_a_marker_does_not_have_is_1(
    page: FakePage, draw: Draw, server: Server, picture: Picture
):
    box = marker(1, frame="", scale=(0.0, 0.2, 0.0))
    display = begin(page, draw, server, interactive("m", control(Control.NONE, "c", box)))
    shown = picture.nodes("/frames/map/display1/marker1/body/control0")["box"]
    np.testing.assert_allclose(shown.batched_scales, [[1.0, 0.2, 1.0]], rtol=1e-6)
    assert display.status == (OK, "")
