"""``moveit_configs_utils``: MoveIt's parameters, from the files of a configuration package."""

from .moveit_configs import MoveItConfigs
from .moveit_configs_builder import MoveItConfigsBuilder

__all__ = ["MoveItConfigs", "MoveItConfigsBuilder"]
