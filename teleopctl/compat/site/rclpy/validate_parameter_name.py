"""``rclpy.validate_parameter_name``. The rules of parameter names: there must be one."""

from teleopctl.node import InvalidParameterException

__all__ = ["validate_parameter_name"]


def validate_parameter_name(name: str) -> bool:
    """Return True; raise when a parameter has no name."""
    if not name:
        raise InvalidParameterException(name)
    return True
