"""Messages as YAML, JSON and CSV, and messages made from YAML."""

from teleopctl.interfaces.yaml.input import documents_from_yaml, message_from_yaml
from teleopctl.interfaces.yaml.output import (
    DEFAULT_TRUNCATION,
    message_to_csv,
    message_to_dict,
    message_to_yaml,
    message_values,
)

__all__ = [
    "DEFAULT_TRUNCATION",
    "documents_from_yaml",
    "message_from_yaml",
    "message_to_csv",
    "message_to_dict",
    "message_to_yaml",
    "message_values",
]
