"""Utilities that need no message types, nodes or robots, for all other packages."""

__version__ = "0.1.0"
