"""The drive page on the viewer's server, and the node that publishes its commands."""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.node import Node, Parameter, SingleThreadedExecutor, spin_in_thread
from teleopctl.nodes.teleop.drive_page.leader_button import LeaderButton
from teleopctl.nodes.teleop.drive_page.messages import (
    GripperWish,
    Hands,
    Press,
    parse_message,
)
from teleopctl.nodes.teleop.hand_driver import HandDriver
from teleopctl.teleop import EPISODE, HandCommand, HandMapping

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from teleopctl.nodes.teleop.drive_page.cameras import DriveCameras
    from teleopctl.viewer import PageRoutes, Viewer

_FOLDER = Path(__file__).parent
_FILES = {
    "/drive": ("drive.html", "text/html; charset=utf-8"),
    "/drive.js": ("drive.js", "text/javascript; charset=utf-8"),
    "/drive_camera.js": ("camera.js", "text/javascript; charset=utf-8"),
}
# Title of the link to the page on the page of the 3D view.
_TITLE = "Drive"
_NODE = "teleop_page"
_SOCKET, _PICTURES = "/drive/socket", "/drive/camera"
_DEVICES = ("keys", "pads", "gamepad")
_STATE_PERIOD_S = 0.1
# Time without a motion after which another browser may drive, s.
_FREE_AFTER_S = 2.0
# Messages that wait to be sent to a browser that reads slowly, in bytes: a newer state is better.
_MOST_WAITING = 16_384


class _PageNode(Node):
    """Node of the drive page, whose timers are those of the wall clock.

    Args:
        use_sim_time: Whether its messages have simulated time.
    """

    def __init__(self, *, use_sim_time: bool) -> None:
        super().__init__(
            _NODE,
            # Launch files name the page's process, which is that of another node.
            cli_args=["--ros-args", "-r", f"__node:={_NODE}"],
            parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)],
        )
        self._time_source.read_on_demand()


class DrivePage:
    """Serves ``/drive`` and drives the robot by its messages; its node starts with the first page.

    Args:
        servo: Name of the servo node.

    Attributes:
        use_sim_time: Whether the node's time is that of ``/clock``; set it before the first page.
    """

    def __init__(self, servo: str = "servo_node") -> None:
        self.use_sim_time = False
        self._servo = servo
        self._driver: HandDriver | None = None
        # Button for a leader arm; None before the first page.
        self.leader: LeaderButton | None = None
        self._node: Node | None = None
        self._mappings: dict[str, HandMapping] = {}
        self._mapped_for: tuple[str, bool] | None = None
        # Browser that moves the robot, and until when others are refused, on the monotonic clock.
        self._hand: DriveSession | None = None
        self._until_s = 0.0
        self._sessions: set[DriveSession] = set()
        # Cameras of the viewer; None before `attach`.
        self._cameras: DriveCameras | None = None

    def add_to(self, routes: PageRoutes) -> None:
        """Add the page, its script and its websocket to the routes of a server."""
        for path, (name, content_type) in _FILES.items():
            routes.add_file(path, (_FOLDER / name).read_bytes(), content_type)
        routes.add_socket(_SOCKET, self._serve)
        routes.add_socket(_PICTURES, self._serve_pictures)
        routes.add_link("/drive", _TITLE)

    def attach(self, viewer: Viewer) -> None:
        """Give the page a viewer's cameras, and a handle at the gripper in its scene.

        The handle is there while a drive page is open. The view moves with a mobile base.
        """
        from teleopctl.nodes.teleop.drive_page.base_view import BaseView
        from teleopctl.nodes.teleop.drive_page.cameras import DriveCameras
        from teleopctl.nodes.teleop.drive_page.handle import DriveHandle

        self._cameras = DriveCameras(viewer)
        for part in (DriveHandle, BaseView):
            part(viewer, lambda: self.driver, lambda: bool(self._sessions))

    def close(self) -> None:
        """Release all inputs, and destroy the node."""
        if self._driver is not None:
            self._driver.close()
        if self._node is not None:
            self._executor.shutdown()
            self._node.destroy_node()

    @property
    def driver(self) -> HandDriver:
        """Driver of the robot, created at its first use."""
        if self._driver is None:
            self._node = _PageNode(use_sim_time=self.use_sim_time)
            self._driver = HandDriver(self._node, "page", self._servo)
            self.leader = LeaderButton(self._node)
            self._executor = SingleThreadedExecutor(context=self._node.context)
            self._executor.add_node(self._node)
            spin_in_thread(self._executor, "drive")
        return self._driver

    def mappings(self) -> Mapping[str, HandMapping]:
        """Return the mapping of each device of the page, for the robot that is driven."""
        driver = self.driver
        robot = (driver.robot, driver.is_base)
        if robot != self._mapped_for:
            self._mappings = {
                name: HandMapping.load(name, driver.robot, is_base=driver.is_base)
                for name in _DEVICES
            }
            self._mapped_for = robot
        return self._mappings

    # --- who moves --------------------------------------------------------------------------------

    def may_move(self, session: DriveSession) -> bool:
        """Return whether a browser may move the robot now, and note that it does."""
        now_s = time.monotonic()
        if self._hand not in (None, session) and now_s < self._until_s:
            return False
        self._hand, self._until_s = session, now_s + _FREE_AFTER_S
        return True

    def take(self, session: DriveSession) -> None:
        """Make a browser the one that drives."""
        if self._hand is not session:
            self.driver.release()
        self.driver.take_over()
        self._hand, self._until_s = session, time.monotonic() + _FREE_AFTER_S

    def let_go(self, session: DriveSession) -> None:
        """Release all inputs of a browser."""
        if self._hand is session:
            self._hand = None
            self.driver.release()

    def is_other(self, session: DriveSession) -> bool:
        """Return whether another browser drives."""
        return self._hand not in (None, session) and time.monotonic() < self._until_s

    def cameras(self) -> list[str]:
        """Return the image topics of the robot's cameras."""
        return [] if self._cameras is None else self._cameras.topics()

    async def _serve_pictures(self, connection: ServerConnection) -> None:
        if self._cameras is not None:
            await self._cameras.serve(connection)

    async def _serve(self, connection: ServerConnection) -> None:
        from websockets.exceptions import ConnectionClosed

        loop = asyncio.get_running_loop()
        # It takes tens of milliseconds, in which the 3D view would stand still.
        await loop.run_in_executor(None, lambda: self.driver)
        session = DriveSession(self)
        self._sessions.add(session)
        states = loop.create_task(self._send_states(connection, session))
        try:
            async for text in connection:
                if (problem := session.received(text)) is not None:
                    await connection.send(json.dumps({"type": "problem", "text": problem}))
        except ConnectionClosed:
            pass
        finally:
            states.cancel()
            self._sessions.discard(session)
            self.let_go(session)

    async def _send_states(self, connection: ServerConnection, session: DriveSession) -> None:
        from websockets.exceptions import ConnectionClosed

        with contextlib.suppress(ConnectionClosed):
            while True:
                if connection.transport.get_write_buffer_size() < _MOST_WAITING:
                    await connection.send(json.dumps(session.state()))
                await asyncio.sleep(_STATE_PERIOD_S)


class DriveSession:
    """A browser that has the drive page open.

    Args:
        page: The page.
    """

    def __init__(self, page: DrivePage) -> None:
        self._page = page
        self._sequence = -1
        self._gamepad_problem = ""
        self._refusal = ""
        # Newest inputs, with the command that they make, and the devices that are held.
        self._hands: Hands | None = None
        self._mappings: Mapping[str, HandMapping] = {}
        self._total = HandCommand()
        self._devices: list[str] = []

    def received(self, text: str | bytes) -> str | None:
        """Process a message of the browser; return an error text, or None."""
        try:
            message = parse_message(text, self._hands)
        except TeleopctlError as error:
            self._page.let_go(self)
            return error.message
        if isinstance(message, Hands):
            self._take_hands(message)
        elif isinstance(message, GripperWish):
            if self._may_move():
                self._page.driver.set_gripper(message.opening)
        else:
            self._press(message)
        return None

    def _take_hands(self, hands: Hands) -> None:
        if hands.sequence <= self._sequence:
            return
        self._sequence = hands.sequence
        self._gamepad_problem = hands.problem
        mappings = self._page.mappings()
        last = self._hands
        if last is None or hands.document is not last.document or mappings is not self._mappings:
            self._total, self._devices = _total(hands, mappings)
        self._hands, self._mappings = hands, mappings
        total, devices = self._total, self._devices
        wants = total.is_held or total.toggles_gripper
        if devices and not self._page.is_other(self):
            self._page.driver.device = " and ".join(devices)
        if "stop" in total.actions or (wants and self._may_move()):
            self._page.driver.apply(total, mappings["keys"].speeds)
        elif not wants:
            self._refusal = ""
            if not self._page.is_other(self):
                self._page.driver.apply(total, mappings["keys"].speeds)

    def _may_move(self) -> bool:
        if self._page.may_move(self):
            self._refusal = ""
            return True
        self._refusal = "another browser drives the robot: let go there, or press Take over"
        return False

    def _press(self, press: Press) -> None:
        driver, page = self._page.driver, self._page
        calls: Mapping[str, Callable[[], object]] = {
            "stop": driver.press_stop,
            "release_stop": driver.release_stop,
            "take": partial(page.take, self),
            "release": partial(page.let_go, self),
        }
        if press.action in calls:
            calls[press.action]()
        elif press.action in ("engage", "disengage"):
            if page.leader is not None:
                page.leader.press(engages=press.action == "engage")
        elif press.action.startswith(EPISODE):
            driver.episodes.press(press.action.removeprefix(EPISODE))
        else:
            steps = page.mappings()["keys"].speeds
            driver.apply(HandCommand(actions=frozenset({press.action})), steps)
            driver.apply(HandCommand(), steps)

    # Any: values of a JSON document.
    def state(self) -> dict[str, Any]:
        """Return the state of the robot and of this browser's inputs, for JSON."""
        speeds = self._page.mappings()["keys"].speeds
        state = self._page.driver.state(speeds)
        holder = state.get("holder")
        opening, wanted_opening = self._page.driver.openings()
        return {
            "type": "state",
            **state,
            "leader": None if self._page.leader is None else self._page.leader.state(),
            "opening": opening,
            "wanted_opening": wanted_opening,
            "speeds": list(speeds),
            "cameras": self._page.cameras(),
            "gamepad_problem": self._gamepad_problem,
            "refusal": self._refusal or state.get("refusal", ""),
            "is_other": self._page.is_other(self) or bool(holder and not holder["is_this"]),
        }


def _total(hands: Hands, mappings: Mapping[str, HandMapping]) -> tuple[HandCommand, list[str]]:
    """Return the command of all inputs of a browser together, and the devices that are held."""
    total = HandCommand()
    devices = []
    for name, sample in hands.samples.items():
        if not sample.buttons and not any(sample.axes.values()):
            continue
        command = mappings[name].command(sample)
        total = total + command
        if command.is_held or command.toggles_gripper:
            devices.append(name)
    return replace(total, drags=hands.drags), devices
