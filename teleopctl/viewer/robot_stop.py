"""Button of the page that stops the robot's motion, and releases it again."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, cast

from teleopctl.node import (
    RELEASE_SERVICE,
    RELEASE_TYPE,
    STOP_TOPIC,
    StopButton,
    StopHolders,
)
from teleopctl.viewer.service_calls import ServiceCalls

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.panels.base import Page

_HINT = (
    "Stops the motion of every robot in the ROS graph: controllers decelerate, and refuse commands "
    "until the robot is released. Not a safety function."
)


class RobotStopControl:
    """Button *Stop robot*, or *Release robot*, above the tabs; visible if a node obeys ``/stop``.

    Args:
        page: The viewer's node, which holds the robot stopped.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._calls = ServiceCalls(page)
        self._button = StopButton(page.node)
        self._holders = StopHolders(page.node, lambda _names: self._show())
        self._stop: Any = page.gui.add_button(
            "Stop robot",
            color="red",
            icon=cast("viser.IconName", "hand-stop"),
            hint=_HINT,
            visible=False,
        )
        self._stop.on_click(page.on_node_thread(lambda _event: self._button.press()))
        self._release: Any = page.gui.add_button(
            "Release robot",
            color="orange",
            icon=cast("viser.IconName", "hand-off"),
            visible=False,
        )
        self._release.on_click(page.on_node_thread(lambda _event: self._on_release()))

    def graph_changed(self) -> None:
        """Show the button if a node other than the viewer subscribes to ``/stop``."""
        self._show()

    def _show(self) -> None:
        holders = self._holders.names
        # The page itself subscribes, also to measure the rate of the topic.
        own = self._page.node.get_fully_qualified_name()
        obeying = any(
            one.full_name != own for one in self._page.node.graph().subscriptions(STOP_TOPIC)
        )
        self._stop.visible = obeying and not holders
        self._release.visible = bool(holders)
        if holders:
            self._release.label = f"Release robot, stopped by {', '.join(holders)}"

    def _on_release(self) -> None:
        self._button.release()
        for name in self._holders.names:
            if name != self._page.node.get_fully_qualified_name():
                self._calls.call(
                    RELEASE_SERVICE.replace("~", name),
                    RELEASE_TYPE,
                    lambda _response: None,
                    partial(self._report_holder, name),
                )

    def _report_holder(self, name: str, reason: str) -> None:
        del reason
        self._page.notify(
            "Still stopped", f"The robot is stopped by {name}: release it there", wrong=True
        )
