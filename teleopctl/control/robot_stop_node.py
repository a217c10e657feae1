"""Stop of the robot in the ROS graph: ``/stop``, and a manager's ``~/stop`` and ``~/release``."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.control.controller_manager import LONGEST_CYCLE_S
from teleopctl.control.robot_stop import RobotStop
from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import RELEASE_SERVICE, RELEASE_TYPE, StopHolders, qos_profile_latched
from teleopctl.robot import STOPPING_TIME_S, read_acceleration_limits

if TYPE_CHECKING:
    from teleopctl.interfaces import AllowableParameterValue
    from teleopctl.node import Node
    from teleopctl.robot import JointLimits

_LIMITS_FILE = "joint_limits_file"
_SERVICE = "~/stop"
# Longest wait for the name of a node that holds the robot, in seconds.
_LONGEST_NAMING_S = 0.3
_LATE = (
    "The robot is not stopped yet: the control cycle does not end, and the joints keep their last "
    "commands until it does"
)


class RobotStopNode:
    """Part of a controller manager's node that sets the state of the robot's stop.

    The robot is stopped while a node holds it on ``/stop``, or after a call of ``~/stop``.
    ``~/release`` releases this manager's robot, even if a node still holds it. ``~/is_stopped``
    (std_msgs/Bool, latched) has the state.

    Args:
        node: Node of the manager.
        stop: State to set.
        parameter: Function that returns a parameter's value. ``joint_limits_file`` is a file with
            acceleration limits, as MoveIt's ``joint_limits.yaml``.
        cycle_lock: Lock that the control loop holds during a cycle.
        on_stop: Called when the robot is stopped.

    Raises:
        InvalidParameterError: The parameter is not a string.
        InvalidFileError: The file of the parameter is invalid.
    """

    def __init__(
        self,
        node: Node,
        stop: RobotStop,
        parameter: Callable[[str], AllowableParameterValue],
        cycle_lock: threading.Lock,
        on_stop: Callable[[], object] = lambda: None,
    ) -> None:
        self._on_stop_of_robot = on_stop
        self._logger = node.get_logger()
        self._stop = stop
        self._cycle_lock = cycle_lock
        self._service_name = node.resolve_service_name(_SERVICE)
        path = parameter(_LIMITS_FILE) or ""
        if not isinstance(path, str):
            raise InvalidParameterError(f"Parameter '{_LIMITS_FILE}' must be a path, got {path!r}")
        self._accelerations = read_acceleration_limits(Path(path)) if path else {}
        self._derived: list[str] = []
        # Whether the cycle that would execute a stop hangs.
        self._is_late = False
        # Any: the class of std_msgs/Bool is generated at run time.
        self._bool: Any = get_message("std_msgs/msg/Bool")
        self._is_stopped = node.create_publisher(self._bool, "~/is_stopped", qos_profile_latched)
        self._is_stopped.publish(self._bool(data=False))
        self._holders = StopHolders(node, self._changed)
        trigger = get_service(RELEASE_TYPE)
        node.create_service(trigger, _SERVICE, self._on_stop)
        node.create_service(trigger, RELEASE_SERVICE, self._on_release)

    def set_limits(self, limits: Mapping[str, JointLimits], inertias: Mapping[str, float]) -> None:
        """Set limits and inertias of the robot's joints, once its description is known."""
        self._derived = self._stop.set_limits(limits, self._accelerations, inertias)

    def _changed(self, names: tuple[str, ...]) -> None:
        was_stopped = self._stop.is_stopped
        self._stop.hold(", ".join(names))
        if names:
            self._on_stop_of_robot()
        # The joints decelerate already.
        names = self._holders.name_all(_LONGEST_NAMING_S)
        self._stop.hold(", ".join(names))
        # The next cycle executes it, unless the cycle hangs.
        if names and not self._cycle_lock.acquire(timeout=LONGEST_CYCLE_S):
            self._is_late = True
            self._logger.error(f"{_LATE}. {self._stop.by} holds the robot stopped from then on")
            threading.Thread(target=self._publish_after_cycle, daemon=True).start()
            return
        self._is_late = False
        if names:
            self._cycle_lock.release()
        if not names:
            self._logger.info("The robot is released")
        elif not was_stopped:
            self._logger.warning(
                f"The robot is stopped by {self._stop.by}: controllers decelerate, and commands "
                "and goals are refused until 'teleopctl stop --robot --release'"
            )
            if self._derived:
                self._logger.info(
                    f"No acceleration limits for {', '.join(self._derived)}: stopping from the "
                    f"velocity limit takes {STOPPING_TIME_S:g} s. Parameter '{_LIMITS_FILE}' names "
                    "a file with limits, as MoveIt's joint_limits.yaml"
                )
                self._derived = []
        self._publish()

    def _publish(self) -> None:
        self._is_stopped.publish(self._bool(data=self._stop.is_stopped))

    def _publish_after_cycle(self) -> None:
        with self._cycle_lock:
            self._is_late = False
        self._publish()

    # Any: messages of a class that is generated at run time.
    def _on_stop(self, request: Any, response: Any) -> Any:
        del request
        self._holders.add(self._service_name, f"a call of {self._service_name}")
        response.success = not self._is_late
        response.message = _LATE if self._is_late else f"The robot is stopped by {self._stop.by}"
        return response

    def _on_release(self, request: Any, response: Any) -> Any:
        del request
        by = self._stop.by
        self._holders.clear()
        response.success = True
        response.message = f"Released; stopped by {by}" if by else "The robot was not stopped"
        return response
