"""``launch_ros.actions.ros_timer``."""

from __future__ import annotations

from launch.actions import TimerAction

from teleopctl.launch import RosTimer


class ROSTimer(TimerAction):
    """Actions that are done later by ROS time, once, unless they are cancelled before."""

    def model_action(self) -> RosTimer:
        """Return what the model does for it."""
        return RosTimer(
            period=self._period,
            steps=self.waiting_steps(),
            is_cancelled=lambda: self._is_cancelled,
            cancel_on_shutdown=self._cancel_on_shutdown,
        )
