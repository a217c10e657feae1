"""Asks MoveIt for the whole planning scene, since what it publishes is what changes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_service
from teleopctl.node import add_type_from_graph

if TYPE_CHECKING:
    from teleopctl.node import Client
    from teleopctl.viewer.displays.base import Stage

# Any stands for messages throughout: their classes are made at run time, from definitions.

_TYPE = "moveit_msgs/srv/GetPlanningScene"
# All parts of moveit_msgs/msg/PlanningSceneComponents but the octomap, which is not drawn: state,
# attached objects, names and shapes of the world's objects, transforms, and colours of objects.
_PARTS = 2 | 4 | 8 | 16 | 64 | 512
_ASK_EVERY_S = 2.0


class SceneRequest:
    """Requests the planning scene repeatedly until it is received.

    Args:
        stage: Whose node asks.
        take: Called on the node's thread with the scene.
    """

    def __init__(self, stage: Stage, take: Callable[[Any], object]) -> None:
        self._stage = stage
        self._take = take
        self._wanted = False
        self._due = 0.0
        self._learning = False
        self._client: Client[Any, Any] | None = None

    def begin(self) -> None:
        """Start requesting, as soon as the service is there."""
        self._wanted, self._due = True, 0.0

    def end(self) -> None:
        """Stop requesting."""
        self._wanted = False
        if self._client is not None:
            self._stage.node.destroy_client(self._client)
            self._client = None

    def tick(self, service: str) -> None:
        """Send a request if one is due and the service is there.

        Args:
            service: The name of the service.
        """
        now = time.monotonic()
        if not self._wanted or now < self._due:
            return
        self._due = now + _ASK_EVERY_S
        if self._learning or not self._stage.node.count_services(service):
            return
        if self._stage.knows(_TYPE):
            self._ask(service)
        else:
            self._learn()

    def _learn(self) -> None:
        node = self._stage.node
        graph = node.graph()
        self._learning = True

        def learned(_result: object) -> None:
            # Where nobody explains it, others may do so later.
            self._learning = False
            if self._stage.knows(_TYPE):
                self._due = 0.0

        self._stage.work(lambda: add_type_from_graph(node, _TYPE, graph), learned)

    def _ask(self, service: str) -> None:
        node = self._stage.node
        if self._client is not None:
            node.destroy_client(self._client)
        kind = get_service(_TYPE)
        self._client = node.create_client(kind, service)
        request = kind.Request()
        request.components.components = _PARTS
        self._client.call_async(request).add_done_callback(self._answered)

    def _answered(self, future: Any) -> None:
        if not self._wanted or future.cancelled() or future.exception() is not None:
            return
        self.end()
        self._take(future.result().scene)
