"""Fixtures and helpers of display tests: displays, tf frames, and the scene of the clients."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from teleopctl import plugins
from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer import Display
from tests.viewer.conftest import FakePage

SECOND = 1_000_000_000
Draw = Callable[..., Display]


class Picture:
    """Scene nodes sent to clients, below a display's root node or another node."""

    def __init__(self, page: FakePage) -> None:
        self._scene: Any = page.scene

    def nodes(self, below: str) -> dict[str, Any]:
        """Return the nodes below a path, except frames, by the rest of their path."""
        return {
            path.removeprefix(below).lstrip("/"): node
            for path, node in self._scene._handle_from_node_name.items()
            if path.startswith(f"{below}/") and type(node).__name__ != "FrameHandle"
        }


@pytest.fixture
def picture(page: FakePage) -> Picture:
    """Fixture: scene nodes that clients have received."""
    return Picture(page)


@pytest.fixture
def draw(page: FakePage) -> Iterator[Draw]:
    """Fixture: function that makes and starts a display; all displays are removed at the end."""
    put_frame(page, "base", "map", Transform())
    page.frames.set_fixed_frame("map")
    page.frames.update()

    def make(rviz_class: str, **given: Any) -> Display:
        kind: type[Display] = plugins.load(plugins.DISPLAYS, rviz_class)
        number = len(page.displays) + 1
        given.setdefault("Topic", {"Value": "/it"})
        display = kind(page, rviz_class, f"/display{number}", given)
        page.displays.append(display)
        display.begin()
        return display

    yield make
    for display in list(page.displays):
        page.remove_display(display)


def put_frame(
    page: FakePage, child: str, parent: str, transform: Transform, stamp: int = SECOND
) -> None:
    """Set the transform of a frame in the tf buffer."""
    page.frames.buffer.set_transform(transform_stamped(parent, child, stamp, transform))


def look(page: FakePage) -> None:
    """Update frames and displays, as the viewer does for each picture."""
    page.frames.update()
    for display in page.displays:
        display.update(jumped_back=False)


def message(type_name: str, frame: str = "map", stamp: int = 0, **fields: Any) -> Any:
    """Return a message with a header and the given fields."""
    made = get_message(type_name)()
    made.header.frame_id = frame
    made.header.stamp.sec, made.header.stamp.nanosec = divmod(stamp, SECOND)
    for name, value in fields.items():
        setattr(made, name, value)
    return made
