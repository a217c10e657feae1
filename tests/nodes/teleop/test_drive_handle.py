"""The handle at the gripper: what is dragged moves, and what was let go is pressed again."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.nodes.teleop.drive_page.handle import DriveHandle
from teleopctl.nodes.teleop.servo_words import OUT_OF_REACH
from teleopctl.tf import Transform


class Driver:
    """Driver that notes where the tool shall go, and may lose the hand."""

    arm = SimpleNamespace(root="world", orients_freely=False)
    status = "Very close to a singularity, emergency stop"
    status_words = ""

    def __init__(self):
        self.pulls: list[Transform | None] = []
        self.notes: list[str] = []
        self.is_pulled = False
        self.refusal = ""

    def tool(self):
        return Transform((0.5, 0.0, 0.5))

    def pull(self, target):
        self.pulls.append(target)
        self.is_pulled = target is not None and not self.refusal
        return self.refusal if target is not None else ""

    def note(self, text, exact=""):
        self.notes.append(text)
        self.exact = exact


class Scene:
    """Page with one handle, which a test drags."""

    def __init__(self):
        self.driver = Driver()
        self._node: Any = SimpleNamespace(position=(0.0, 0.0, 0.0), wxyz=(1.0, 0.0, 0.0, 0.0))
        self._calls: dict[str, Any] = {}
        self._node.on_update = lambda updated: self._calls.update(updated=updated)
        viewer: Any = SimpleNamespace(
            is_visible=True,
            server=SimpleNamespace(on_client_disconnect=lambda _: None),
            scene_view=SimpleNamespace(set_pickable=lambda *, pickable: None),
            frames=SimpleNamespace(node_path=lambda _: "/world"),
            scene=SimpleNamespace(add_transform_controls=lambda *_, **__: self._node),
            create_timer=lambda _, follow, clock: self._calls.update(follow=follow),
        )
        driver: Any = self.driver
        DriveHandle(viewer, lambda: driver, lambda: True)
        self.follow()

    def follow(self):
        """Let time pass until the handle is looked at."""
        self._calls["follow"]()

    def drag(self, phase, x=0.6):
        """Drag the handle; return whether the tool is pulled there."""
        self._node.position = (x, 0.0, 0.5)
        self.driver.pulls.clear()
        asyncio.run(self._calls["updated"](SimpleNamespace(phase=phase, client_id=1)))
        return any(pull is not None for pull in self.driver.pulls)


@pytest.fixture
def scene():
    return Scene()


def test_the_tool_follows_from_the_press_to_the_release(scene):
    assert scene.drag("start")
    assert scene.drag("update", 0.62)
    assert not scene.drag("end", 0.62)
    assert not scene.drag("update", 0.64)


@pytest.mark.parametrize("is_seen", [False, True], ids=["at the next drag", "before"])
def test_a_hand_that_was_lost_is_pressed_again(scene, is_seen):
    assert scene.drag("start")
    scene.driver.is_pulled = False  # silence, or another hand
    if is_seen:
        scene.follow()
    assert not scene.drag("update", 0.7)
    assert not scene.drag("update", 0.8)
    assert scene.drag("start")


def test_a_refusal_lets_go_and_is_shown(scene):
    scene.driver.refusal = "another hand drives"
    scene.drag("start")
    assert scene.driver.notes == ["another hand drives"]
    scene.driver.refusal = ""
    assert not scene.drag("update")


@pytest.mark.parametrize(
    "words", ["", "The arm is stretched to its end"], ids=["no reason of servo", "servo's"]
)
def test_a_handle_that_is_not_followed_springs_back_with_a_sentence(scene, monkeypatch, words):
    now_s = [100.0]
    monkeypatch.setattr("teleopctl.nodes.teleop.drive_page.handle.time.monotonic", lambda: now_s[0])
    scene.driver.status_words = words
    assert scene.drag("start")
    scene.follow()
    now_s[0] += 5.0
    scene.follow()
    assert scene.driver.notes == [words or OUT_OF_REACH]
    assert scene.driver.exact == scene.driver.status
    assert not scene.driver.is_pulled
