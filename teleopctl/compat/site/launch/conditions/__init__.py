"""``launch.conditions``."""

from .if_condition import IfCondition
from .unless_condition import UnlessCondition

__all__ = ["IfCondition", "UnlessCondition"]
