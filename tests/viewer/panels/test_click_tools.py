"""Clicks into the scene that become a goal, an estimate or a point."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies
from viser import SceneClickEvent

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer.page_server import PageError
from teleopctl.viewer.panels.click_tools import TOOLS, ClickTools, ground_point
from teleopctl.viewer.rviz_file import RvizFile
from tests.viewer.conftest import FakeClient, FakePage
from tests.viewer.panels.live import LivePage

# Any stands for messages, and for viser's parts.


class Publisher:
    """Keeps what is published."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.sent: list[Any] = []
        self.listeners = 1

    def publish(self, message: Any) -> None:
        self.sent.append(message)

    def get_subscription_count(self) -> int:
        return self.listeners


class Hand:
    """A person with the tools."""

    def __init__(self, page: FakePage, tools: list[dict[str, Any]] | None = None) -> None:
        self.page = page
        self.publishers: list[Publisher] = []
        page.scene_view = SimpleNamespace(
            file=RvizFile({"Visualization Manager": {"Tools": tools or []}}), displays=[]
        )
        self.row = ClickTools(page)
        self.row.build()

    def fix(self, name: str) -> None:
        self.page.frames.set_fixed_frame(name)
        self.page.frames.update()

    def publisher(self, _kind: Any, topic: str, _qos: Any) -> Publisher:
        self.publishers.append(Publisher(topic))
        return self.publishers[-1]

    def press(self, title: str) -> None:
        self.page.choose(self.row._buttons, title)

    def click(self, x: float, y: float, *, client_id: int = FakeClient.client_id) -> None:
        """Click on a place of the ground, seen from above at an angle."""
        self.ray((x - 3.0, y + 4.0, 5.0), (3.0, -4.0, -5.0), client_id=client_id)

    def ray(self, origin: Any, direction: Any, *, client_id: int = FakeClient.client_id) -> None:
        client: Any = self.page.client
        event = SceneClickEvent(client, client_id, origin, direction, (0.5, 0.5), None)
        for entry in list(self.page.scene._scene_pointer_cb):
            entry.callback(event)

    @property
    def said(self) -> str:
        return html.unescape(str(self.row._advice.content))

    @property
    def sent(self) -> list[Any]:
        return [message for publisher in self.publishers for message in publisher.sent]

    @property
    def listens(self) -> bool:
        return bool(self.page.scene._scene_pointer_cb)


@pytest.fixture
def hand(stage: FakePage) -> Iterator[Hand]:
    made = Hand(stage)
    stage.node.create_publisher = made.publisher
    made.fix("map")
    yield made
    made.row.deactivate()


def yaw_of(pose: Any) -> float:
    return 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


def test_a_goal_is_where_the_first_click_is_and_looks_to_the_second(
    hand: Hand, stage: FakePage
) -> None:
    stage.node.now_ns = 7_000_000_005
    hand.press("Goal")
    assert hand.said == "Goal for /goal_pose: click on the ground"
    hand.click(1.0, 2.0)
    assert hand.sent == []
    hand.click(1.0, 3.0)
    (goal,) = hand.sent
    assert goal.TYPE_NAME == "geometry_msgs/msg/PoseStamped"
    assert (goal.header.frame_id, goal.header.stamp.sec, goal.header.stamp.nanosec) == ("map", 7, 5)
    place = goal.pose.position
    assert (place.x, place.y, place.z) == pytest.approx((1.0, 2.0, 0.0))
    assert yaw_of(goal.pose) == pytest.approx(math.pi / 2)
    assert hand.publishers[0].topic == "/goal_pose"
    # The tool is put away: the next click is one at the picture.
    assert not hand.listens
    hand.click(5.0, 5.0)
    assert len(hand.sent) == 1


def test_an_estimate_has_rvizs_covariance(hand: Hand) -> None:
    hand.press("Estimate")
    hand.click(0.0, 0.0)
    hand.click(-1.0, 0.0)
    (estimate,) = hand.sent
    assert hand.publishers[0].topic == "/initialpose"
    assert yaw_of(estimate.pose.pose) == pytest.approx(math.pi)
    found = {index: value for index, value in enumerate(estimate.pose.covariance) if value}
    assert found == pytest.approx({0: 0.25, 7: 0.25, 35: 0.06853891909122467})


def test_a_point_takes_one_click(hand: Hand) -> None:
    hand.press("Point")
    hand.click(-1.5, 0.25)
    (point,) = hand.sent
    assert hand.publishers[0].topic == "/clicked_point"
    assert (point.point.x, point.point.y, point.point.z) == pytest.approx((-1.5, 0.25, 0.0))
    assert "Published on /clicked_point: -1.50, 0.25" in hand.said


def test_topics_and_covariances_are_those_of_the_file(stage: FakePage) -> None:
    tools: list[dict[str, Any]] = [
        {"Class": "rviz_default_plugins/SetInitialPose", "Covariance x": 0.5, "Covariance y": "no"},
        {"Class": "rviz/SetGoal", "Topic": "/move_base_simple/goal"},
        {"Class": "rviz_default_plugins/PublishPoint", "Topic": {"Value": "here"}},
    ]
    hand = Hand(stage, tools)
    stage.node.create_publisher = hand.publisher
    hand.fix("map")
    for tool in TOOLS:
        hand.press(tool.title)
        hand.click(0.0, 0.0)
        hand.click(1.0, 0.0)
    topics = [publisher.topic for publisher in hand.publishers]
    assert topics == ["/move_base_simple/goal", "/initialpose", "here"]
    assert hand.sent[1].pose.covariance[0] == 0.5
    assert hand.sent[1].pose.covariance[7] == 0.25


def test_a_button_pressed_again_puts_its_tool_away(hand: Hand) -> None:
    hand.press("Goal")
    hand.click(1.0, 1.0)
    assert hand.listens
    hand.press("Goal")
    assert not hand.listens
    hand.press("Goal")
    hand.press("Point")
    hand.click(2.0, 2.0)
    assert [message.TYPE_NAME for message in hand.sent] == ["geometry_msgs/msg/PointStamped"]


def test_what_somebody_else_clicks_is_not_taken(hand: Hand) -> None:
    hand.press("Point")
    hand.click(1.0, 1.0, client_id=99)
    assert hand.sent == []
    hand.click(2.0, 2.0)
    assert len(hand.sent) == 1


def test_a_click_into_the_sky_is_told_and_the_next_one_counts(hand: Hand) -> None:
    hand.press("Point")
    hand.ray((0.0, 0.0, 1.0), (1.0, 0.0, 0.5))
    assert "not on the ground" in hand.said
    hand.click(1.0, 1.0)
    assert len(hand.sent) == 1


def test_in_another_fixed_frame_the_first_click_is_to_be_made_again(hand: Hand) -> None:
    hand.press("Goal")
    hand.click(1.0, 1.0)
    hand.page.frames.buffer.set_transform(transform_stamped("map", "odom", 1, Transform()))
    hand.fix("odom")
    hand.click(2.0, 2.0)
    hand.click(3.0, 2.0)
    (goal,) = hand.sent
    assert goal.header.frame_id == "odom"
    assert goal.pose.position.x == pytest.approx(2.0)


def test_that_nobody_listens_is_told(hand: Hand) -> None:
    hand.press("Point")
    hand.publishers[0].listeners = 0
    hand.click(1.0, 1.0)
    assert "no subscriber" in hand.said


def test_without_a_fixed_frame_there_is_no_ground(stage: FakePage) -> None:
    hand = Hand(stage)
    with pytest.raises(PageError, match="no fixed frame"):
        hand.press("Goal")
    assert not hand.listens


def test_when_nobody_looks_any_more_the_tool_is_put_away(hand: Hand) -> None:
    hand.press("Goal")
    hand.click(1.0, 1.0)
    hand.row.deactivate()
    assert not hand.listens
    assert not hand.said
    assert not [name for name in hand.page.scene._handle_from_node_name if "/click_tool/" in name]


def test_a_goal_arrives(live: LivePage) -> None:
    hand = Hand(live)
    hand.fix("map")
    received: list[Any] = []
    live.node.create_subscription(
        get_message("geometry_msgs/msg/PoseStamped"), "/goal_pose", received.append, 1
    )
    hand.press("Goal")
    (publisher,) = hand.row._publishers.values()
    live.until(lambda: publisher.get_subscription_count() == 1)
    hand.click(1.0, 2.0)
    hand.click(2.0, 2.0)
    live.until(lambda: received)
    assert received[0].pose.position.y == pytest.approx(2.0)


numbers = strategies.floats() | strategies.floats(-10.0, 10.0)
rays = strategies.tuples(numbers, numbers, numbers)


@given(rays, rays)
def test_a_ray_meets_the_ground_in_front_of_it_or_not_at_all(origin: Any, direction: Any) -> None:
    place = ground_point(origin, direction)
    if place is None:
        return
    assert all(map(math.isfinite, place))
    assert place[2] == 0.0
    ahead = sum((b - a) * c for a, b, c in zip(origin, place, direction, strict=True))
    assert ahead >= 0.0
