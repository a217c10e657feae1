"""Handle at the gripper in the 3D view, for dragging the arm."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.node import Clock, ClockType
from teleopctl.nodes.teleop.servo_words import OUT_OF_REACH
from teleopctl.tf import Transform

if TYPE_CHECKING:
    import viser

    from teleopctl.nodes.teleop.hand_driver import HandDriver
    from teleopctl.viewer import Viewer

_PERIOD_S = 0.05
# Distance, m, and change of the quaternion, for which the handle is not moved.
_SAME = 1e-5
# Size as part of the distance of the tool from the root link, and its range, m.
_SIZE, _LEAST_M, _MOST_M = 0.16, 0.05, 0.3
# The arm does not follow if the handle is this far ahead, m, and the tool has moved less than that
# for that time, m and s.
_AHEAD_M, _STILL_M, _STILL_S = 0.04, 0.004, 0.8


class DriveHandle:
    """Handle that follows the gripper, and that the gripper follows while it is dragged.

    It springs back to the gripper when the arm cannot follow, and the reason is shown.

    Args:
        viewer: Viewer of the 3D scene.
        driver: Function that returns the driver of the robot.
        is_open: Function that returns whether a drive page is open; otherwise there is no handle.
    """

    def __init__(
        self, viewer: Viewer, driver: Callable[[], HandDriver], is_open: Callable[[], bool]
    ) -> None:
        self._viewer, self._driver, self._is_open = viewer, driver, is_open
        self._node: viser.TransformControlsHandle | None = None
        # Browser that drags the handle; None while none does.
        self._client: int | None = None
        self._begin: Transform | None = None
        self._is_first = False
        self._still_since_s = 0.0
        self._last = Transform()
        # Position and rotation at which the handle was put last; empty if it may be elsewhere.
        self._shown: tuple[float, ...] = ()
        viewer.server.on_client_disconnect(lambda client: self._release_handle(client.client_id))
        viewer.create_timer(_PERIOD_S, self._follow, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _follow(self) -> None:
        """Move the handle with the gripper, or end a drag that the arm cannot follow."""
        is_open = self._is_open()
        if is_open and self._client is None and not self._viewer.is_visible:
            return
        # A press on the handle would be a click on the link behind it.
        self._viewer.scene_view.set_pickable(pickable=not is_open)
        if not is_open:
            if self._node is not None:
                self._release_handle(self._client)
                self._node.remove()
                self._node = None
            return
        driver = self._driver()
        tool, arm = driver.tool(), driver.arm
        if tool is None or arm is None:
            return
        if self._node is None:
            self._node = self._add(arm.root, tool, turns=arm.orients_freely)
            self._shown = ()
        if self._client is not None and not self._is_first and not driver.is_pulled:
            # Samples were missing, or another node drives: only a new press moves the arm.
            self._release_handle(self._client)
        if self._client is None:
            # Arrows of an arm that does not turn its tool keep their directions in the room: those
            # of the tool may point at the eye, and a drag along them is no motion on the screen.
            self._move(tool if arm.orients_freely else Transform(tool.translation))
            return
        now_s = time.monotonic()
        if _distance(tool, self._last) > _STILL_M:
            self._last, self._still_since_s = tool, now_s
        ahead_m = _distance(tool, _pose(self._node))
        if ahead_m > _AHEAD_M and now_s - self._still_since_s > _STILL_S:
            # Before the release, after which servo has no reason any more.
            words, exact = driver.status_words or OUT_OF_REACH, driver.status
            self._release_handle(self._client)
            driver.note(words, exact)

    def _add(self, root: str, tool: Transform, *, turns: bool) -> viser.TransformControlsHandle:
        path = f"{self._viewer.frames.node_path(root)}/drive_handle"
        reach_m = _distance(tool, Transform())
        node = self._viewer.scene.add_transform_controls(
            path,
            scale=min(max(_SIZE * reach_m, _LEAST_M), _MOST_M),
            disable_rotations=not turns,
            depth_test=False,
        )

        # On the server's event loop, so that updates stay in their order.
        async def updated(event: Any) -> None:
            self._on_update(event)

        node.on_update(updated)
        return node

    # Any: an event of viser.
    def _on_update(self, event: Any) -> None:
        tool = self._driver().tool()
        if event.phase == "start" and tool is not None:
            self._is_first = True
            self._client, self._begin = event.client_id, tool
            self._last, self._still_since_s = tool, time.monotonic()
        if self._client != event.client_id or self._begin is None or self._node is None:
            return
        if event.phase == "end":
            self._release_handle(event.client_id)
            return
        if not self._is_first and not self._driver().is_pulled:
            self._release_handle(event.client_id)
            return
        wanted = _pose(self._node)
        arm = self._driver().arm
        if arm is None or not arm.orients_freely:
            wanted = Transform(wanted.translation, self._begin.rotation)
        refusal = self._driver().pull(wanted)
        self._is_first = False
        if refusal:
            self._release_handle(event.client_id)
            self._driver().note(refusal)

    def _release_handle(self, client: int | None) -> None:
        if client is not None and client == self._client:
            self._client = self._begin = None
            self._shown = ()
            self._driver().pull(None)

    def _move(self, pose: Transform) -> None:
        assert self._node is not None
        numbers = (*pose.translation, *pose.rotation)
        if self._shown and math.dist(numbers, self._shown) < _SAME:
            return
        self._shown = numbers
        x, y, z, w = pose.rotation
        self._node.position, self._node.wxyz = pose.translation, (w, x, y, z)


def _pose(node: viser.TransformControlsHandle) -> Transform:
    """Return the pose of a handle in the frame of its parent."""
    w, x, y, z = (float(value) for value in node.wxyz)
    at = [float(value) for value in node.position]
    return Transform((at[0], at[1], at[2]), (x, y, z, w))


def _distance(one: Transform, other: Transform) -> float:
    pairs = zip(one.translation, other.translation, strict=True)
    return math.sqrt(sum((a - b) ** 2 for a, b in pairs))
