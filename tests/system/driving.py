"""A person who drives the teleop arm on the drive page: sees where things are, and holds hands."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from playwright.sync_api import Page

from teleopctl.interfaces import get_message
from teleopctl.kinematics import Arm, load_description
from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.viewer.rviz_file import RvizFile
from tests import ROOT

# Point between the fingertips in the frame of claw_support, m, and the middle of the bin.
GRASP = (-0.13, 0.596, -0.106)
UP = np.array([0.0, 0.0, 1.0])
BIN = np.array([-1.3, 0.75, 0.5])
_NEAR_M = 0.012
FINGER = "joint_4"
VIEW = ROOT / "teleopctl/share/teleopctl/config/drive.rviz"
_FIELD_OF_VIEW = np.radians(75.0)  # of the page's camera, from top to bottom


class Hand(Protocol):
    """Way in which a person moves the arm on the page; all values are -1 to 1."""

    def move(self, forward: float, left: float, up: float) -> None:
        """Hold what moves the gripper in a direction, or let go for zeros."""

    def grip(self, opening: float) -> None:
        """Hold what opens (1) or closes (0) the gripper."""

    def let_go(self) -> None:
        """Let go of what moves the gripper's fingers."""


class KeysHand:
    """Keys of the keyboard, pressed and released."""

    def __init__(self, page: Page, person: Driver) -> None:
        del person
        self._keyboard = page.keyboard
        self._held: set[str] = set()

    def move(self, forward: float, left: float, up: float) -> None:
        wanted: set[str] = set()
        for value, plus, minus in (
            (forward, "ArrowUp", "ArrowDown"),
            (left, "ArrowLeft", "ArrowRight"),
            (up, "KeyW", "KeyS"),
        ):
            if abs(value) > 0.05:
                wanted.add(plus if value > 0.0 else minus)
        if wanted and max(abs(forward), abs(left), abs(up)) < 0.4:
            wanted.add("ShiftLeft")
        self._hold(wanted)

    def grip(self, opening: float) -> None:
        self._hold({"KeyE" if opening > 0.5 else "KeyQ"})

    def let_go(self) -> None:
        self._hold(set())

    def _hold(self, wanted: set[str]) -> None:
        for key in self._held - wanted:
            self._keyboard.up(key)
        for key in wanted - self._held:
            self._keyboard.down(key)
        self._held = wanted


class PadsHand:
    """Two thumbs on the touch pads, and one on the slider."""

    def __init__(self, page: Page, person: Driver) -> None:
        del person
        self._page = page
        self._session = page.context.new_cdp_session(page)
        self._points: dict[str, tuple[float, float]] = {}

    def move(self, forward: float, left: float, up: float) -> None:
        wanted = {}
        if max(abs(forward), abs(left)) > 0.05:
            wanted["left"] = self._at("#left", -left, forward)
        if abs(up) > 0.05:
            wanted["right"] = self._at("#right", 0.0, up)
        self._touch(wanted)

    def grip(self, opening: float) -> None:
        _, y = self._at("#gripper", 0.0, 0.0)
        box = self._page.locator("#gripper").bounding_box()
        assert box is not None
        self._touch({"slider": (box["x"] + 6 + opening * (box["width"] - 12), y)})

    def let_go(self) -> None:
        self._touch({})

    def _at(self, place: str, x: float, y: float) -> tuple[float, float]:
        box = self._page.locator(place).bounding_box()
        assert box is not None
        return (
            box["x"] + box["width"] * (0.5 + 0.4 * x),
            box["y"] + box["height"] * (0.5 - 0.4 * y),
        )

    def _touch(self, wanted: dict[str, tuple[float, float]]) -> None:
        for name in [*self._points]:
            if name not in wanted:
                del self._points[name]
                self._send("touchEnd" if not self._points else "touchMove")
        for name, at in wanted.items():
            is_new = name not in self._points
            self._points[name] = at
            self._send("touchStart" if is_new else "touchMove")

    def _send(self, kind: str) -> None:
        points = [{"x": x, "y": y, "id": len(name)} for name, (x, y) in self._points.items()]
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


FAKE_GAMEPAD = """
window.fakePad = {id: "Test Pad", mapping: "standard", connected: true, index: 0,
  axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false, value: 0}))};
navigator.getGamepads = () => [window.fakePad, null, null, null];
"""


class GamepadHand:
    """Gamepad that the page reads by the browser's interface, emulated in the page."""

    def __init__(self, page: Page, person: Driver) -> None:
        del person
        self._page = page

    def move(self, forward: float, left: float, up: float) -> None:
        held = max(abs(forward), abs(left), abs(up)) > 0.05
        self._set([-left, -forward, 0.0, -up], {4} if held else set())

    def grip(self, opening: float) -> None:
        self._set([0.0] * 4, {4, 5 if opening > 0.5 else 7})

    def let_go(self) -> None:
        self._set([0.0] * 4, set())

    def _set(self, axes: list[float], pressed: set[int]) -> None:
        self._page.evaluate(
            """([axes, pressed]) => {
              window.fakePad.axes = axes;
              window.fakePad.buttons.forEach((button, i) => {
                button.pressed = pressed.includes(i);
                button.value = button.pressed ? 1 : 0;
              });
            }""",
            [axes, sorted(pressed)],
        )


class HandleHand(KeysHand):
    """Mouse that drags the arrows of the handle in the 3D view; the gripper by its keys."""

    # Where an arrow is grasped, and how far the mouse moves along it at once, m.
    _GRASP_M, _STEP_M = 0.2, 0.02

    def __init__(self, page: Page, person: Driver) -> None:
        super().__init__(page, person)
        self._page, self._person = page, person
        view = RvizFile.load(VIEW).view
        assert view is not None
        self._eye = np.array(view.eye)
        ahead = np.array(view.focus) - self._eye
        ahead /= np.linalg.norm(ahead)
        across = np.cross(ahead, UP)
        across /= np.linalg.norm(across)
        self._axes = np.array([across, np.cross(ahead, across), ahead])
        # Arrow that is held, and the point at which the mouse drags it, m.
        self._axis: int | None = None
        self._at = np.zeros(3)

    def move(self, forward: float, left: float, up: float) -> None:
        speed = np.array([-left, forward, up])
        if self._axis is not None and not speed[self._axis]:
            self._page.mouse.up()
            self._axis = None
            return
        if not speed.any():
            return
        if self._axis is None:
            self._axis = int(np.argmax(np.abs(speed)))
            self._at = self._person.gripper()
            self._at[self._axis] += self._GRASP_M
            self._point()
            self._person.pause(0.5)  # until the page has seen which arrow is below the mouse
            self._page.mouse.down()
        self._at[self._axis] += self._STEP_M * speed[self._axis]
        self._point()

    def _point(self) -> None:
        """Move the mouse to where the point is drawn."""
        box = self._page.locator("#view").bounding_box()
        assert box is not None
        x, y, away = self._axes @ (self._at - self._eye)
        scale = 0.5 * box["height"] / np.tan(0.5 * _FIELD_OF_VIEW) / away
        self._page.mouse.move(
            box["x"] + 0.5 * box["width"] + scale * x, box["y"] + 0.5 * box["height"] + scale * y
        )


class Driver:
    """Eyes of the person: where gripper and cube are, by topics; moves a hand until they fit.

    Attributes:
        pause: Waits for a time in s.
    """

    def __init__(self, node: Node, model: str) -> None:
        self.pause: Callable[[float], object] = time.sleep
        self._arm = Arm(load_description(Path(model)), tool=GRASP)
        self._positions: dict[str, float] = {}
        self._cube: Any = None
        node.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "joint_states", self._on_states, 1
        )
        node.create_subscription(
            get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray"),
            "/mujoco_sim/free_joint_states",
            self._on_bodies,
            1,
        )

    # Any: message classes are generated at run time.
    def _on_states(self, message: Any) -> None:
        self._positions = dict(zip(message.name, message.position, strict=False))

    def _on_bodies(self, message: Any) -> None:
        self._cube = next((body.pose.pose.position for body in message.free_joints), None)

    def cube(self) -> np.ndarray:
        """Return where the cube is, (3,), m."""
        return np.array([self._cube.x, self._cube.y, self._cube.z])

    def gripper(self) -> np.ndarray:
        """Return where the point between the fingertips is, (3,), m."""
        return self._arm.fk([self._positions[name] for name in self._arm.names])[:3, 3].copy()

    def wait_for_fingers(self, timeout_s: float = 30.0) -> None:
        """Wait until the fingers move."""
        end_s, begin = time.monotonic() + timeout_s, self._positions[FINGER]
        while abs(self._positions[FINGER] - begin) < 5e-3:
            assert time.monotonic() < end_s, "the fingers do not move"
            self.pause(0.02)

    def grip(self, hand: Hand, opening: float, timeout_s: float = 90.0) -> None:
        """Open or close the gripper, until the fingers stand still."""
        end_s = time.monotonic() + timeout_s
        begin, before, still = self._positions[FINGER], np.inf, 0
        hand.grip(opening)
        while still < 5:
            assert time.monotonic() < end_s, "the fingers do not stand still"
            self.pause(0.2)
            at = self._positions[FINGER]
            still = still + 1 if abs(at - before) < 2e-3 and abs(at - begin) > 0.02 else 0
            before = at
        hand.let_go()

    def wait(self, timeout_s: float = 20.0) -> None:
        """Wait until gripper and cube are seen."""
        end_s = time.monotonic() + timeout_s
        while not self._positions or self._cube is None:
            assert time.monotonic() < end_s, "no joint states or no cube"
            time.sleep(0.02)

    def move_to(
        self, hand: Hand, target: np.ndarray, timeout_s: float = 120.0, near_m: float = _NEAR_M
    ) -> None:
        """Hold a hand until the gripper is at a target."""
        end_s = time.monotonic() + timeout_s
        while (away := target - self.gripper()) @ away > near_m**2:
            assert time.monotonic() < end_s, f"{away.round(3)} m are left"
            # The arm points along y: that is forward, and x is to the right.
            # Beyond the dead middle of sticks and pads.
            speed = np.sign(away) * np.clip(np.abs(away) * 6.0, 0.25, 1.0)
            speed[np.abs(away) < 0.4 * near_m] = 0.0
            hand.move(float(speed[1]), float(-speed[0]), float(speed[2]))
            self.pause(0.03)
        hand.move(0.0, 0.0, 0.0)
        self.pause(0.3)

    def bring_cube(self, hand: Hand) -> bool:
        """Bring the cube into the bin; return whether it lies there."""
        self.grip(hand, 1.0)
        cube = self.cube()
        self.move_to(hand, cube + UP * 0.25)
        self.move_to(hand, cube)
        self.grip(hand, 0.0)
        self.move_to(hand, self.gripper() + UP * 0.35)
        self.move_to(hand, np.array([-1.0, 1.1, self.gripper()[2]]), near_m=0.05)
        self.move_to(hand, BIN, near_m=0.05)
        self.grip(hand, 1.0)
        self.pause(1.0)
        return bool((np.abs(self.cube()[:2] - BIN[:2]) < 0.2).all() and self.cube()[2] < 0.3)


@contextmanager
def driver(model: str) -> Iterator[Driver]:
    """Yield a driver with a node of its own."""
    context = Context()
    context.init()
    node = Node("person", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    try:
        yield Driver(node, model)
    finally:
        executor.shutdown()
        context.shutdown()


def hand_of(name: str) -> Callable[[Page, Driver], Hand]:
    """Return the class of a hand by the name of its device."""
    hands: dict[str, Callable[[Page, Driver], Hand]] = {
        "handle": HandleHand,
        "keys": KeysHand,
        "pads": PadsHand,
        "gamepad": GamepadHand,
    }
    return hands[name]
