"""Messages as YAML, JSON and CSV, and messages made from YAML."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.interfaces.yaml.input import (
        documents_from_yaml as documents_from_yaml,
        message_from_yaml as message_from_yaml,
    )
    from teleopctl.interfaces.yaml.output import (
        DEFAULT_TRUNCATION as DEFAULT_TRUNCATION,
        message_to_csv as message_to_csv,
        message_to_dict as message_to_dict,
        message_to_yaml as message_to_yaml,
        message_values as message_values,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
