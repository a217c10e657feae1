"""What the tests of displays share: displays that are drawn, frames, and what browsers have."""

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
    """What browsers have been sent below a display's root, or below anything else."""

    def __init__(self, page: FakePage) -> None:
        self._scene: Any = page.scene

    def nodes(self, below: str) -> dict[str, Any]:
        """The visible nodes whose path begins so, by the rest of it."""
        return {
            path.removeprefix(below).lstrip("/"): node
            for path, node in self._scene._handle_from_node_name.items()
            if path.startswith(f"{below}/") and type(node).__name__ != "FrameHandle"
        }


@pytest.fixture
def picture(page: FakePage) -> Picture:
    """What browsers have."""
    return Picture(page)


@pytest.fixture
def draw(page: FakePage) -> Iterator[Draw]:
    """Makes a display that is drawn; all are ended afterwards."""
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
    """Tell tf where a frame stands."""
    page.frames.buffer.set_transform(transform_stamped(parent, child, stamp, transform))


def look(page: FakePage) -> None:
    """The next picture."""
    page.frames.update()
    for display in page.displays:
        display.update(jumped_back=False)


def message(type_name: str, frame: str = "map", stamp: int = 0, **fields: Any) -> Any:
    """A message with a header."""
    made = get_message(type_name)()
    made.header.frame_id = frame
    made.header.stamp.sec, made.header.stamp.nanosec = divmod(stamp, SECOND)
    for name, value in fields.items():
        setattr(made, name, value)
    return made
