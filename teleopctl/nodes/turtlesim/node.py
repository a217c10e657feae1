"""Executable ``turtlesim_node``: the simulation of turtles that draw."""

from __future__ import annotations

import argparse
import contextlib
import math
import queue
import random
import sys
from collections.abc import Callable
from typing import Any

from teleopctl.base import progress
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import (
    Clock,
    ClockType,
    ExternalShutdownException,
    Node,
    init,
    parse_ros_arguments,
    spin,
)
from teleopctl.nodes.rviz2 import add_page_options, report_address
from teleopctl.nodes.turtlesim.board import BACKGROUND, LOOKS, SIZE, Board, Colour, single
from teleopctl.nodes.turtlesim.turtle import TICK_S, Turtle

_CHANNELS = (("r", "Red"), ("g", "Green"), ("b", "Blue"))
_LARGEST = 255

# Any, here and below: message classes are generated at run time from definitions.


class TurtleSim(Node):
    """Node that simulates turtles on a board, with ROS 2's services, parameters and log lines.

    Attributes:
        board: The board with the lines of the pens.
        turtles: Turtles by name.
        show: Called in each period with the board, its background and the turtles.
    """

    def __init__(self) -> None:
        super().__init__("turtlesim")
        self.board = Board()
        self.turtles: dict[str, Turtle] = {}
        self.show: Callable[[Board, Colour, list[Turtle]], object] = lambda *_: None
        self._count = 0
        self._orders: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
        levels = get_message("rcl_interfaces/msg/IntegerRange")(to_value=_LARGEST, step=1)
        for channel, name in _CHANNELS:
            self.declare_parameter(
                f"background_{channel}",
                getattr(BACKGROUND, channel),
                descriptor(
                    description=f"{name} channel of the background color", integer_range=[levels]
                ),
            )
        self.declare_parameter(
            "holonomic", False, descriptor(description="If true, then turtles will be holonomic")
        )
        empty = get_service("std_srvs/srv/Empty")
        self.create_service(empty, "clear", self._on_clear)
        self.create_service(empty, "reset", self._on_reset)
        self.create_service(get_service("turtlesim/srv/Spawn"), "spawn", self._on_spawn)
        self.create_service(get_service("turtlesim/srv/Kill"), "kill", self._on_kill)
        self.get_logger().info(
            f"Starting turtlesim with node name {self.get_fully_qualified_name()}"
        )
        self._spawn_first()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(TICK_S, self.tick, clock=steady)

    @property
    def background(self) -> Colour:
        """Background of the board, from the parameters."""
        return Colour(
            *(int(self.get_parameter(f"background_{channel}").value) for channel, _ in _CHANNELS)
        )

    def tick(self) -> None:
        """Simulate one period."""
        with contextlib.suppress(queue.Empty):
            while True:
                self._orders.get_nowait()()
        for turtle in self.turtles.values():
            turtle.tick(self.board)
        self.show(self.board, self.background, list(self.turtles.values()))

    def clear(self) -> None:
        """Remove all lines from the board, in the next period; may be called on any thread."""
        self._orders.put(self._clear)

    def reset(self) -> None:
        """Reset to one turtle, in the next period; thread-safe."""
        self._orders.put(self._reset)

    # --- services ---------------------------------------------------------------------------------

    def _on_clear(self, _: Any, response: Any) -> Any:
        self._clear()
        return response

    def _clear(self) -> None:
        self.get_logger().info("Clearing turtlesim.")
        self.board.clear()

    def _on_reset(self, _: Any, response: Any) -> Any:
        self._reset()
        return response

    def _reset(self) -> None:
        self.get_logger().info("Resetting turtlesim.")
        for turtle in self.turtles.values():
            turtle.destroy()
        self.turtles.clear()
        self._count = 0
        self._spawn_first()
        self.board.clear()

    def _on_spawn(self, request: Any, response: Any) -> Any:
        if request.name in self.turtles:
            self.get_logger().error(f"A turtle named [{request.name}] already exists")
        elif not all(map(math.isfinite, (request.x, request.y, request.theta))):
            self.get_logger().error("No turtle is spawned: its place is not finite")
        else:
            try:
                response.name = self._spawn(request.name, request.x, request.y, request.theta)
            except TeleopctlError as error:
                # A name that no topic may have.
                self.get_logger().error(f"No turtle is spawned: {error.message}")
        return response

    def _on_kill(self, request: Any, response: Any) -> Any:
        turtle = self.turtles.pop(request.name, None)
        if turtle is None:
            self.get_logger().error(f"Tried to kill turtle [{request.name}], which does not exist")
        else:
            turtle.destroy()
        return response

    def _spawn_first(self) -> None:
        self._spawn("", single(SIZE / 2.0), single(SIZE / 2.0), 0.0)

    def _spawn(self, name: str, x: float, y: float, theta: float) -> str:
        """Add a turtle, named turtle1, turtle2 and so on if ``name`` is empty; return its name."""
        while not name or name in self.turtles:
            self._count += 1
            name = f"turtle{self._count}"
        self.turtles[name] = Turtle(
            self,
            name,
            x,
            single(SIZE - y),
            theta,
            random.randrange(LOOKS),  # noqa: S311 -- not for security
            lambda: bool(self.get_parameter("holonomic").value),
        )
        self.get_logger().info(
            f"Spawning turtle [{name}] at x=[{x:f}], y=[{y:f}], theta=[{theta:f}]"
        )
        return name


def main(args: list[str] | None = None) -> int:
    """Simulate turtles, shown on a web page, until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        TeleopctlError: The page cannot be opened, or a parameter is wrong.
    """
    from teleopctl.nodes.turtlesim.window import TurtleWindow
    from teleopctl.viewer import close_server, open_page

    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(prog="turtlesim_node", description="Turtles that draw.")
    add_page_options(parser)
    options = parser.parse_args(parse_ros_arguments(words).program)
    progress.report(progress.STARTING)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=words),
        TurtleSim() as node,
        contextlib.ExitStack() as stack,
    ):
        server, address = open_page(options.host, options.port, options.token_file)
        stack.callback(close_server, server)
        node.show = TurtleWindow(server, node.clear, node.reset).show
        node.get_logger().info(f"The window is at {address.url}")
        report_address(address, open_it=options.open)
        spin(node)
    return 0
