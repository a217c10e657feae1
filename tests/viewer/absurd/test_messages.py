"""Every display, with messages and properties that make no sense."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies

from teleopctl import plugins
from teleopctl.interfaces import get_message
from teleopctl.tf import Transform
from teleopctl.viewer import Display
from teleopctl.viewer.displays.base import ERROR, OK, WARN
from tests.samples import sample
from tests.viewer.absurd.messages import Absurd, WithoutNumbers
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import Draw, look, put_frame
from tests.viewer.displays.test_interactive_markers import Server
from tests.viewer.displays.test_moveit import URDF
from tests.viewer.displays.test_points import cloud

# Any stands for messages, and for viser's handles of any kind.

DISPLAYS = tuple(plugins.DISPLAYS.builtin)
# What displays listen to besides their topic, by how its name ends.
BESIDES = {
    "_updates": "map_msgs/msg/OccupancyGridUpdate",
    "camera_info": "sensor_msgs/msg/CameraInfo",
    "/display_planned_path": "moveit_msgs/msg/DisplayTrajectory",
}
KNOWN_TOPICS = (*BESIDES, "/robot_description")
WITHOUT_TOPIC = {"Axes", "Grid", "TF", "Trace"}
seeds = strategies.integers(0, 2**32)
several = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def begun(page: FakePage, draw: Draw, rviz_class: str, made: Absurd, **given: Any) -> Display:
    """The display, in a picture with a robot and frames, and the others gone."""
    for display in list(page.displays):
        page.remove_display(display)
    server = Server(page)
    put_frame(page, "base", "map", Transform((1.0, 0.0, 0.0)))
    display = draw(rviz_class, **given)
    page.publish("/robot_description", get_message("std_msgs/msg/String")(data=URDF))
    look(page)
    if server.requests:
        kind = "visualization_msgs/msg/InteractiveMarker"
        server.answer(0, *[made.message(kind) for _ in range(2)])
    page.node.warnings.clear()
    return display


def see(page: FakePage, display: Display) -> None:
    """The next picture, whatever it waits for."""
    parts: tuple[Any, ...] = (display, getattr(display, "_feed", None))
    for part in parts:
        if hasattr(part, "_due"):
            part._due = 0.0
    look(page)
    # What another thread has put together is drawn with the next one.
    look(page)


def check_scene(page: FakePage) -> None:
    """What browsers have been sent are numbers that they can draw."""
    scene: Any = page.scene
    for name, handle in scene._handle_from_node_name.items():
        values = {"position": handle.position, "wxyz": handle.wxyz, **vars(handle._impl.props)}
        for key, value in values.items():
            if isinstance(value, float | np.ndarray) and np.asarray(value).dtype.kind == "f":
                numbers = np.asarray(value, np.float64)
                assert np.isfinite(numbers).all(), (name, key, value)
                assert not numbers.size or np.abs(numbers).max() < 1e20, (name, key, value)


def heard(page: FakePage, display: Display) -> list[tuple[str, str]]:
    """The topics that a display listens to, and the types of their messages."""
    found = []
    for topic, listening in page.subscribed.items():
        if listening and topic == display.topic:
            found += [(topic, kind) for kind in (display.message_type, *display.other_types)]
        elif listening:
            found += [(topic, kind) for end, kind in BESIDES.items() if topic.endswith(end)]
            # Those of odd properties are relative.
            assert topic.endswith(KNOWN_TOPICS) or topic[0] != "/", topic
    return found


def publish(page: FakePage, display: Display, made: Absurd, number: int) -> None:
    """Send a message of each type that a display listens to."""
    for topic, kind in heard(page, display):
        message = made.message(kind)
        if hasattr(message, "seq_num"):
            # What is out of order is not looked at.
            message.seq_num, message.type = number + 1, message.UPDATE
        if hasattr(message, "point_step") and isinstance(made, WithoutNumbers):
            nowhere = [math.nan, math.nan]
            message = cloud({"x": nowhere, "y": nowhere, "z": nowhere}, frame="map")
        page.publish(topic, message)


@pytest.mark.parametrize("rviz_class", sample(DISPLAYS, 4))
@given(seed=seeds)
@several
def test_no_message_ends_the_picture(
    page: FakePage, draw: Draw, rviz_class: str, seed: int
) -> None:
    display = begun(page, draw, rviz_class, Absurd(seed))
    for number in range(3):
        publish(page, display, Absurd(seed + number), number)
        see(page, display)
        assert not page.node.warnings
        check_scene(page)
    level, text = display.status
    assert level in (OK, WARN, ERROR)
    assert text or level == OK
    display.end()
    assert not page.node.warnings


@pytest.mark.parametrize("rviz_class", DISPLAYS)
def test_what_is_no_number_is_left_out_and_that_is_told(
    page: FakePage, draw: Draw, rviz_class: str
) -> None:
    made = WithoutNumbers()
    display = begun(page, draw, rviz_class, made)
    if rviz_class in WITHOUT_TOPIC:
        return
    publish(page, display, made, 0)
    see(page, display)
    level, text = display.status
    # No return and none on this ray are usual: of points there is no warning, but the count.
    assert level != OK or text.startswith("0 of 2 points")
    assert text
    check_scene(page)


# --- properties --------------------------------------------------------------------------------

odd = (
    strategies.none()
    | strategies.booleans()
    | strategies.sampled_from([0, -1, 2**70, 1e30, math.nan, math.inf, -math.inf, 1e-300])
    | strategies.sampled_from(["", "x", "1; 2", "-1; 300; nan", "<Fixed Frame>", "/", "..", "\0"])
    | strategies.sampled_from([[], {}, [1], {"Value": None}, {"Value": {"Value": 1}}, {"Topic": 3}])
)


@pytest.mark.parametrize("rviz_class", sample(DISPLAYS[::-1], 4))
@given(data=strategies.data())
@several
def test_no_property_of_a_file_ends_the_picture(
    page: FakePage, draw: Draw, rviz_class: str, data: strategies.DataObject
) -> None:
    kind: type[Display] = plugins.load(plugins.DISPLAYS, rviz_class)
    given: dict[str, Any] = {}
    others = ("Enabled", "Links", "Namespaces", "Frames")
    for name in (*(known.name.split("/")[0] for known in kind.properties), *others):
        if name == "Enabled" or data.draw(strategies.booleans(), label=name):
            given[name] = data.draw(odd)
    for key in {"Topic", kind.topic_key} - {""}:
        given[key] = data.draw(strategies.just({"Value": "/it"}) | odd)
    made = Absurd(data.draw(seeds))
    display = begun(page, draw, rviz_class, made, **given)
    publish(page, display, made, 0)
    for known in kind.properties:
        display.set(known.name, display.values[known.name])
    see(page, display)
    assert all("Invalid topic name" in text for text in page.node.warnings)
    check_scene(page)


def test_a_topic_that_no_topic_can_be_is_told_once_and_nothing_else_suffers(
    page: FakePage, draw: Draw
) -> None:
    display = draw("Path", Topic={"Value": "bad topic!"})
    for _ in range(3):
        display.end()
        display.begin()
        look(page)
    level, text = display.status
    assert level == ERROR
    assert "'bad topic!'" in text
    assert "\n" not in text
    assert len(page.node.warnings) == 1
    display.set_topic("/good")
    assert display.status == (OK, "")
