"""``moveit_configs_utils.substitutions``."""

from .xacro import Xacro

__all__ = ["Xacro"]
