"""Messages as YAML, JSON and CSV: one place to import both directions from."""

from teleopctl.interfaces.yaml_input import message_from_yaml
from teleopctl.interfaces.yaml_output import (
    DEFAULT_TRUNCATION,
    message_to_csv,
    message_to_dict,
    message_to_yaml,
)

__all__ = [
    "DEFAULT_TRUNCATION",
    "message_from_yaml",
    "message_to_csv",
    "message_to_dict",
    "message_to_yaml",
]
