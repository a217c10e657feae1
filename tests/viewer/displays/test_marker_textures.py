"""Pictures on the triangles of markers: what browsers are sent is what RViz shows."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from teleopctl.interfaces import get_message
from teleopctl.viewer import OK, WARN
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import Draw, Picture, look
from tests.viewer.displays.test_geometry import pose
from tests.viewer.displays.test_markers import Marker, marker, points, rgba

UVCoordinate = get_message("visualization_msgs/msg/UVCoordinate")
UV = [(0.0, 1.0), (1.0, 1.0), (0.0, 0.0)]


def picture_file(color: tuple[int, ...] = (10, 200, 30), kind: str = "PNG") -> bytes:
    """The bytes of a picture's file."""
    stored = io.BytesIO()
    Image.new("RGB" if len(color) == 3 else "RGBA", (4, 2), color).save(stored, kind)
    return stored.getvalue()


def textured(data: bytes = b"", name: str = "embedded://board", **fields: Any) -> Any:
    """A triangle with a picture on it."""
    fields.setdefault("points", points((0, 0), (1, 0), (0, 1)))
    fields.setdefault("color", (1.0, 1.0, 1.0, 1.0))
    made = marker(Marker.TRIANGLE_LIST, 0, texture_resource=name, **fields)
    made.uv_coordinates = [UVCoordinate(u=u, v=v) for u, v in UV]
    made.texture.format, made.texture.data = "png", data
    return made


class Gltf:
    """What a binary glTF says, and the bytes of its parts."""

    def __init__(self, data: bytes) -> None:
        (length,) = struct.unpack("<I", data[12:16])
        # Any stands for what JSON holds.
        self.described: dict[str, Any] = json.loads(data[20 : 20 + length])
        self._numbers = data[28 + length :]

    def view(self, number: int) -> bytes:
        said = self.described["bufferViews"][number]
        return self._numbers[said["byteOffset"] : said["byteOffset"] + said["byteLength"]]

    def floats(self, attribute: str) -> list[list[float]]:
        accessor = self.described["accessors"][
            self.described["meshes"][0]["primitives"][0]["attributes"][attribute]
        ]
        rows = np.frombuffer(self.view(accessor["bufferView"]), np.float32)
        rows = rows.reshape(accessor["count"], -1)
        return [[float(part) for part in row] for row in rows]

    def picture(self) -> tuple[str, bytes]:
        (image,) = self.described["images"]
        return image["mimeType"], self.view(image["bufferView"])

    def material(self) -> Any:
        (one,) = self.described["materials"]
        return one


def shown(page: FakePage, picture: Picture, *said: Any) -> Any:
    """The node of the one surface that is drawn after these messages."""
    for one in said:
        page.publish("/it", one)
    look(page)
    return picture.nodes("/display1")["surface0"]


def test_the_picture_in_a_message_lies_on_its_triangles(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Marker")
    data = picture_file()
    made = Gltf(shown(page, picture, textured(data, scale=(2.0, 1.0, 1.0))).glb_data)
    assert made.picture() == ("image/png", data)
    assert made.floats("POSITION") == [[0, 0, 0], [2, 0, 0], [0, 1, 0]]
    assert made.floats("TEXCOORD_0") == [list(one) for one in UV]
    # lit, as RViz has it, and seen from both sides
    assert "extensions" not in made.material()
    assert made.material()["doubleSided"]
    assert made.material()["alphaMode"] == "OPAQUE"
    assert display.status == (OK, "")


def test_the_picture_of_a_file_is_multiplied_by_the_colour_and_seen_through_where_it_is_clear(
    page: FakePage, draw: Draw, picture: Picture, tmp_path: Path
):
    draw("Marker")
    file = tmp_path / "board.bmp"
    Image.new("RGB", (4, 2), (10, 200, 30)).save(file)
    node = shown(page, picture, textured(name=f"file://{file}", color=(1.0, 0.0, 0.0, 1.0)))
    kind, data = Gltf(node.glb_data).picture()
    assert kind == "image/png"  # browsers know no BMP within glTF
    assert Image.open(io.BytesIO(data)).getpixel((0, 0)) == (10, 200, 30)
    reflecting = Gltf(node.glb_data).material()["pbrMetallicRoughness"]
    assert reflecting["baseColorFactor"] == [1, 0, 0, 1]
    node = shown(page, picture, textured(picture_file((10, 200, 30, 90))))
    assert Gltf(node.glb_data).material()["alphaMode"] == "BLEND"


@pytest.mark.parametrize(
    ("spoilt", "reason"),
    [
        (lambda one: setattr(one.texture, "data", b"no picture"), "cannot be read"),
        (lambda one: setattr(one.texture, "data", b""), "has no data"),
        (lambda one: setattr(one, "texture_resource", "file:///no/such.png"), "/no/such.png"),
        (lambda one: one.uv_coordinates.pop(), "2 uv_coordinates for 3 points"),
        (lambda one: setattr(one.uv_coordinates[0], "u", float("nan")), "not finite"),
    ],
)
def test_without_its_picture_a_surface_is_drawn_in_its_colour_and_says_why(
    page: FakePage,
    draw: Draw,
    picture: Picture,
    spoilt: Callable[[Any], object],
    reason: str,
):
    display = draw("Marker")
    said = textured(picture_file(), color=(0.0, 1.0, 0.0, 1.0))
    spoilt(said)
    assert shown(page, picture, said).color == (0, 255, 0)
    assert display.status[0] == WARN
    assert reason in display.status[1]


def test_a_picture_is_not_sent_again_when_its_surface_moves(
    page: FakePage, draw: Draw, picture: Picture, monkeypatch: pytest.MonkeyPatch
):
    draw("Marker")
    data = picture_file()
    before = shown(page, picture, textured(data))
    sent: list[Any] = []
    monkeypatch.setattr(page.scene, "_queue_scene_message", sent.append)
    after = shown(page, picture, textured(data, pose=pose(3.0, 4.0)))
    assert after is before
    assert after.position.tolist() == [3, 4, 0]
    assert not [one for one in sent if hasattr(one, "props")]


def test_of_pictures_that_come_faster_than_they_are_read_the_old_are_let_go(
    page: FakePage, draw: Draw, picture: Picture, monkeypatch: pytest.MonkeyPatch
):
    display: Any = draw("Marker")
    first = shown(page, picture, textured(picture_file((0, 0, 0))))
    held: list[Callable[[], object]] = []

    def run_in_background(task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        held.append(lambda: then(task()))

    monkeypatch.setattr(page, "run_in_background", run_in_background)
    for number in range(1, 60):
        # what is there stays until the next can be shown
        node = shown(page, picture, textured(picture_file((number, 0, 0))))
        assert node is first
    while held:
        held.pop(0)()
        look(page)
    _, data = Gltf(picture.nodes("/display1")["surface0"].glb_data).picture()
    assert data == picture_file((59, 0, 0))
    read = display.markers._files.textures
    assert len(read) < 10


def test_each_corner_of_a_textured_surface_may_have_a_colour(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Marker")
    said = textured(picture_file(), color=(0.0, 0.0, 0.0, 0.0))
    said.colors = [rgba(1.0, 1.0, 1.0, 1.0)] * 3
    made = Gltf(shown(page, picture, said).glb_data)
    assert set(made.described["meshes"][0]["primitives"][0]["attributes"]) == {
        "POSITION",
        "COLOR_0",
        "TEXCOORD_0",
    }
