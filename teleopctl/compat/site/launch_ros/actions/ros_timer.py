"""``launch_ros.actions.ros_timer``."""

from __future__ import annotations

from launch.actions import TimerAction

from teleopctl.launch import RosTimer


class ROSTimer(TimerAction):
    """Executes actions once after a period of ROS time, unless it is cancelled before."""

    def model_action(self) -> RosTimer:
        """Return the corresponding action of `teleopctl.launch`."""
        return RosTimer(
            period=self._period,
            steps=self.waiting_steps(),
            is_cancelled=lambda: self._is_cancelled,
            cancel_on_shutdown=self._cancel_on_shutdown,
        )
