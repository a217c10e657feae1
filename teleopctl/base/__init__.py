"""Utilities that need no message types, nodes or robots, for all other packages.

May import `errors` only.
"""

__version__ = "0.1.0"
