"""``rclpy.parameter``. Parameters."""

from teleopctl.node import (
    Parameter,
    parameter_messages,
    parameter_value_from_yaml,
    parameter_value_to_python,
)

__all__ = [
    "PARAMETER_SEPARATOR_STRING",
    "Parameter",
    "get_parameter_value",
    "parameter_dict_from_yaml_file",
    "parameter_value_to_python",
]

PARAMETER_SEPARATOR_STRING = "."

get_parameter_value = parameter_value_from_yaml
parameter_dict_from_yaml_file = parameter_messages
