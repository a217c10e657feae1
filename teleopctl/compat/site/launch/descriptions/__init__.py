"""``launch.descriptions``."""

from .executable import Executable

__all__ = ["Executable"]
