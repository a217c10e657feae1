"""Topics ``~/controller_state`` and ``~/DOF/pid_state`` of a PID controller."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.control.realtime_publisher import PublishQueue, RealtimePublisher
from teleopctl.interfaces import from_seconds, get_message, set_stamp

if TYPE_CHECKING:
    from teleopctl.control.controllers.pid import PidGains
    from teleopctl.node import Node

# Any: message classes are generated at run time from definitions.


class PidStep(NamedTuple):
    """Record of one PID step of one degree of freedom, as published; NaN where missing.

    Attributes:
        reference: Reference value.
        feedback: Measured value.
        feedback_dot: Derivative of the measured value.
        error: Reference minus measured value, the shortest rotation for angles.
        error_dot: Reference minus measured derivative.
        output: Commanded value, the previous one if the step commanded nothing.
        integral: Integral part of the output.
        error_rate: Error rate that the PID used.
        gains: Gains of the PID.
    """

    reference: float
    feedback: float
    feedback_dot: float
    error: float
    error_dot: float
    output: float
    integral: float
    error_rate: float
    gains: PidGains


class PidStatePublisher:
    """Realtime publisher of ``~/controller_state`` and, if configured, ``~/DOF/pid_state``.

    Args:
        node: Node of the controller.
        queue: Publish queue of the control loop.
        names: State names of the degrees of freedom.
        own: Command names of the degrees of freedom with a topic ``~/DOF/pid_state``.
        dofs: Command names of all degrees of freedom.
    """

    def __init__(
        self,
        node: Node,
        queue: PublishQueue,
        names: Sequence[str],
        own: Sequence[str],
        dofs: Sequence[str],
    ) -> None:
        # Messages are created once and reused.
        kind: Any = get_message("control_msgs/msg/MultiDOFStateStamped")
        state: Any = get_message("control_msgs/msg/SingleDOFState")
        self._node = node
        self._message: Any = kind(dof_states=[state(name=name) for name in names])
        self._publisher = node.create_publisher(kind, "~/controller_state", 10)
        self._realtime = RealtimePublisher(queue, self._publish)
        self._own: dict[int, Any] = {}
        for dof in own:
            from teleopctl.node import qos_profile_sensor_data

            pid: Any = get_message("control_msgs/msg/PidState")
            publisher = node.create_publisher(pid, f"~/{dof}/pid_state", qos_profile_sensor_data)
            self._own[dofs.index(dof)] = (pid(), publisher)

    def close(self) -> None:
        """Destroy the publishers of controller and PID states."""
        for _, publisher in self._own.values():
            self._node.destroy_publisher(publisher)
        self._node.destroy_publisher(self._publisher)

    def try_publish(self, time_ns: int, period: float, steps: Sequence[PidStep]) -> None:
        """Queue the PID steps of one update for publishing after the control cycle."""
        self._realtime.try_publish((time_ns, period, steps))

    def _publish(self, value: tuple[int, float, Sequence[PidStep]]) -> None:
        time_ns, period, steps = value
        message = self._message
        set_stamp(message.header.stamp, time_ns)
        for state, step in zip(message.dof_states, steps, strict=True):
            state.reference, state.feedback, state.error = step.reference, step.feedback, step.error
            # As in ROS 2: 0 without a derivative.
            state.feedback_dot = 0.0 if math.isnan(step.feedback_dot) else step.feedback_dot
            state.error_dot = 0.0 if math.isnan(step.error_dot) else step.error_dot
            state.time_step, state.output = period, step.output
        self._publisher.publish(message)
        for number, (own, publisher) in self._own.items():
            step = steps[number]
            set_stamp(own.header.stamp, time_ns)
            set_stamp(own.timestep, from_seconds(period))
            own.error, own.error_dot = step.error, step.error_rate
            own.p_error, own.i_error, own.d_error = step.error, step.integral, step.error_rate
            gains = step.gains
            own.p_term, own.i_term, own.d_term = gains.p, gains.i, gains.d
            own.i_max, own.i_min = gains.i_clamp_max, gains.i_clamp_min
            own.output = step.output
            publisher.publish(own)
