"""``/performance_metrics``: how fast a simulation runs, as Gazebo tells it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.interfaces import get_message, set_stamp
from teleopctl.node import Clock

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.lockstep import LockstepLoop
    from teleopctl.sim.simulation import Simulation

_PerformanceMetrics = get_message("gazebo_msgs/msg/PerformanceMetrics")
# How often, in seconds of wall time.
_PERIOD_S = 1.0


class PerformancePublisher:
    """Publishes the measured real-time factor, while it has subscribers.

    Args:
        node: Who publishes.
        simulation: Whose time it is.
        loop: What runs it.
    """

    def __init__(self, node: Node, simulation: Simulation, loop: LockstepLoop) -> None:
        self._simulation, self._loop = simulation, loop
        self._message = _PerformanceMetrics()
        self._publisher = node.create_publisher(_PerformanceMetrics, "/performance_metrics", 10)
        node.create_timer(_PERIOD_S, self._publish, clock=Clock())

    def _publish(self) -> None:
        if self._publisher.get_subscription_count() > 0:
            set_stamp(self._message.header.stamp, self._simulation.time_ns)
            self._message.real_time_factor = self._loop.reached_factor
            self._publisher.publish(self._message)
