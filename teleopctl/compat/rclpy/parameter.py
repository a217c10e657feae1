"""``rclpy.parameter``. Parameters."""

from teleopctl.node.parameter import Parameter, parameter_value_to_python

__all__ = ["Parameter", "parameter_value_to_python"]
