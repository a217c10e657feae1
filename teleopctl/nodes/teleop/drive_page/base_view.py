"""View of the drive page that moves with a mobile base, which would leave it otherwise."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.node import Clock, ClockType
from teleopctl.nodes.teleop.hand_driver import HandDriver
from teleopctl.viewer import Viewer

_PERIOD_S = 0.5
# Direction from a base to the camera behind it, whose x axis is forward (REP 103).
_BEHIND = (-1.0, 0.35, 0.6)
# Cells of the grid along each side: those of RViz, 10, are left in seconds.
_CELLS = 200


class BaseView:
    """Lets the cameras of all drive pages follow the root link of a mobile base.

    Args:
        viewer: Viewer of the 3D scene.
        driver: Function that returns the driver of the robot.
        is_open: Function that returns whether a drive page is open.
    """

    def __init__(
        self, viewer: Viewer, driver: Callable[[], HandDriver], is_open: Callable[[], bool]
    ) -> None:
        self._viewer, self._driver, self._is_open = viewer, driver, is_open
        self._has_ground = False
        viewer.create_timer(_PERIOD_S, self.follow, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def follow(self) -> None:
        """Let the cameras of drive pages that have come follow the base."""
        if not self._is_open():
            return
        driver = self._driver()
        description = driver.robot_state.description
        if description is None or not driver.is_base:
            return
        server, scene = self._viewer.server, self._viewer.scene_view
        if not self._has_ground and scene.path is None:
            self._has_ground = True
            for display in scene.displays:
                if display.rviz_class == "Grid":
                    display.set("Plane Cell Count", _CELLS)
        for browser, client in server.get_clients().items():
            if server.clients.is_embedded(browser) and not scene.followed(browser):
                # An .rviz file's own view stays.
                if scene.path is None:
                    scene.frame_robot(client.camera, _BEHIND)
                scene.follow(browser, description.root)
