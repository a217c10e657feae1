"""``ros_gz_sim.actions``."""

from .gz_spawn_model import GzSpawnModel
from .gzserver import GzServer

__all__ = ["GzServer", "GzSpawnModel"]
