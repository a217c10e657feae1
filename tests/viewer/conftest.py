"""Fixtures for tests of displays and panels: a page on viser's server, and a simulated graph."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import SimpleNamespace
from typing import Any

import pytest
from viser import GuiEvent, ViserServer

from teleopctl.node import QoSProfile, Time
from teleopctl.node.values.names import validate_name
from teleopctl.tf import Transform
from teleopctl.viewer import open_server
from teleopctl.viewer.scene.frames import FrameBuffer, SceneFrames


class FakeClient:
    """Client of a browser that records downloads.

    Attributes:
        files: Contents of files that were sent for download, by name.
    """

    client_id = 1

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}

    def send_file_download(self, filename: str, content: bytes, **_: object) -> None:
        self.files[filename] = content


class FakeNode:
    """Node with the methods that displays and panels call.

    Attributes:
        topics: Types of published topics, by topic.
        warnings: Logged warnings.
        now_ns: Time of the node's clock in nanoseconds, set by the test.
    """

    def __init__(self) -> None:
        self.topics: dict[str, list[str]] = {}
        self.warnings: list[str] = []
        self.now_ns = 0

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        profile = QoSProfile(depth=1)
        return [
            SimpleNamespace(topic_type=kind, qos_profile=profile)
            for kind in self.topics.get(topic, ())
        ]

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return sorted(self.topics.items())

    def count_publishers(self, topic: str) -> int:
        return len(self.topics.get(topic, ()))

    def count_services(self, service: str) -> int:
        return len(self.topics.get(service, ()))

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=lambda text, **_: self.warnings.append(text))

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: Time(nanoseconds=self.now_ns))


class FakePage:
    """Page and stage in one, as the viewer's node is; runs every task at once, in the test.

    Args:
        server: Server of the page.
        node: Node of the page; a `FakeNode` by default.

    Attributes:
        subscribed: Callbacks of the subscriptions, by topic.
        told: Title and text of the notifications sent to all clients.
        last_camera_pose: Pose of a client's camera, or None.
        resets: Number of requested resets.
        scripts: Scripts that were run, each with the browser's ID.
        filled: Texts of elements of the page's HTML, by ID.
    """

    def __init__(self, server: ViserServer, node: Any = None) -> None:
        self.node: Any = FakeNode() if node is None else node
        self.stage = self
        self.server = server
        self.scene = server.scene
        self.gui = server.gui
        self.frames = SceneFrames(server.scene, FrameBuffer())
        self.robot_folder: Any = None
        self.displays: list[Any] = []
        self.scene_view: Any = None
        self.workspace: Any = None
        self.client = FakeClient()
        self.subscribed: dict[str, list[Callable[[Any], object]]] = {}
        self.told: list[tuple[str, str]] = []
        self.last_camera_pose: Transform | None = None
        self.resets = 0
        self._shared: dict[Callable[[Any], Any], Any] = {}
        self.filled: dict[str, str] = {}
        self.scripts: list[tuple[int, str]] = []

    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: object
    ) -> Callable[[], None]:
        del type_name, qos
        validate_name(topic)
        self.subscribed.setdefault(topic, []).append(callback)

        def end() -> None:
            self.subscribed[topic].remove(callback)

        return end

    def knows_type(self, type_name: str) -> bool:
        return bool(type_name)

    def camera(self) -> Transform | None:
        return self.last_camera_pose

    def publish(self, topic: str, message: object) -> None:
        """Call the callbacks of a topic's subscriptions with a message."""
        for callback in tuple(self.subscribed.get(topic, ())):
            callback(message)

    def listens_to(self, topic: str) -> bool:
        return bool(self.subscribed.get(topic))

    def run_in_background(self, task: Callable[[], Any], then: Callable[[Any], object]) -> None:
        try:
            result = task()
        except Exception as error:  # noqa: BLE001 -- as in the viewer
            result = error
        then(result)

    def on_node_thread(self, function: Callable[..., object]) -> Callable[..., None]:
        def call(*arguments: Any) -> None:
            function(*arguments)

        return call

    def guarded(self, function: Callable[..., object], *arguments: object) -> str:
        function(*arguments)
        return ""

    def shared(self, kind: Callable[[Any], Any]) -> Any:
        if kind not in self._shared:
            self._shared[kind] = kind(self)
        return self._shared[kind]

    def reset(self) -> None:
        self.resets += 1

    def notify(self, title: str, text: str = "", *, wrong: bool = False) -> None:
        del wrong
        self.told.append((title, text))

    def fill(self, texts: Mapping[str, str]) -> None:
        self.filled.update(texts)

    def run_script(self, client_id: int, script: str) -> None:
        self.scripts.append((client_id, script))

    def remove_display(self, display: Any) -> None:
        display.end()
        self.displays.remove(display)

    # --- actions of a person on the page ------------------------------------------------------

    def click(self, handle: Any) -> None:
        """Simulate a click on a button."""
        self._happen(handle)

    def choose(self, handle: Any, value: object) -> None:
        """Set the value of a dropdown, checkbox, text field or button group, as a person does."""
        handle._impl.value = value
        self._happen(handle)

    def _happen(self, handle: Any) -> None:
        client: Any = self.client
        for callback in handle._impl.update_cb:
            callback(GuiEvent(client, client.client_id, handle))


@pytest.fixture(scope="module")
def page_server() -> Iterator[ViserServer]:
    """Fixture: server of all pages of a test module."""
    server = open_server(port=0)
    yield server
    server.stop()


@pytest.fixture
def page(page_server: ViserServer) -> Iterator[FakePage]:
    """Fixture: page of one test, whose scene is cleared at the end."""
    page = FakePage(page_server)
    yield page
    page.frames.remove()
    page_server.gui.reset()
    page_server.scene.reset()


@pytest.fixture
def stage(page):
    """Fixture: the page as the stage of displays, with a simulated graph of its own."""
    page.node = FakeNode()
    return page
