"""Page with a real node in a ROS graph, and real nodes as its peers."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from viser import ViserServer

from teleopctl.control import ControllerManagerNode
from teleopctl.interfaces import get_message
from teleopctl.node import (
    Context,
    Executor,
    Node,
    QoSProfile,
    SingleThreadedExecutor,
    get_default_context,
    init,
    qos_profile_latched,
    try_shutdown,
)
from teleopctl.testing import LONGEST_WAIT_S
from teleopctl.viewer.panels.base import Panel
from tests.viewer.conftest import FakePage

String = get_message("std_msgs/msg/String")


class LivePage(FakePage):
    """Page with a real node, which spins on the test's thread during `until`."""

    def __init__(self, server: ViserServer) -> None:
        self.context = Context()
        self.context.init([])
        super().__init__(server, Node("rviz", context=self.context))
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._is_changed = False
        self.node.add_graph_callback(self._take_change)
        self.panels: list[Panel] = []

    def _take_change(self) -> None:
        self._is_changed = True

    def show(self, panel: Panel) -> None:
        """Build a panel and call its `began`, as when a browser opens the page."""
        self.panels.append(panel)
        panel.build()
        panel.began()

    def subscribe(
        self, topic: str, type_name: str, callback: Callable[[Any], object], qos: object
    ) -> Callable[[], None]:
        assert isinstance(qos, QoSProfile)
        subscription = self.node.create_subscription(get_message(type_name), topic, callback, qos)

        def end() -> None:
            self.node.destroy_subscription(subscription)

        return end

    def until(self, holds: Callable[[], object], timeout_s: float = LONGEST_WAIT_S) -> None:
        """Spin until a condition is true, with the panels' graph callbacks and ticks; or fail."""
        deadline = time.monotonic() + timeout_s
        while not holds():
            assert time.monotonic() < deadline, f"waited in vain; told: {self.told}"
            self._executor.spin_once(0.02)
            if self._is_changed:
                self._is_changed = False
                for panel in self.panels:
                    panel.graph_changed()
            for panel in self.panels:
                panel.tick()

    def close(self) -> None:
        for panel in self.panels:
            panel.ended()
            panel.close()
        self.context.try_shutdown()
        self.frames.remove()
        self.server.gui.reset()
        self.server.scene.reset()


@contextmanager
def spinning(*make: Callable[[Context, Executor], Any]) -> Iterator[list[Any]]:
    """Yield other nodes of the graph, which a thread spins during the ``with`` block.

    Args:
        make: Functions of context and executor, each of which returns a node or `ManagerProcess`.
    """
    # Controllers create their nodes in the default context.
    context = get_default_context()
    init(args=[])
    executor = SingleThreadedExecutor(context=context)
    made = [function(context, executor) for function in make]
    for one in made:
        if isinstance(one, Node):
            executor.add_node(one)
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(0.05)

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    try:
        yield made
    finally:
        over.set()
        thread.join()
        for one in made:
            if isinstance(one, ManagerProcess):
                one.manager.close()
        try_shutdown()


class ManagerProcess:
    """Controller manager in this process, and a publisher of its robot description."""

    def __init__(
        self,
        context: Context,
        executor: Executor,
        /,
        urdf: str,
        arguments: list[str],
        namespace: str = "",
    ) -> None:
        self.node = Node(
            "controller_manager",
            context=context,
            namespace=namespace,
            cli_args=arguments,
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        executor.add_node(self.node)
        self.publisher = self.node.create_publisher(
            String, "robot_description", qos_profile_latched
        )
        self.manager = ControllerManagerNode(self.node, executor, arguments)
        self.publisher.publish(String(data=urdf))
