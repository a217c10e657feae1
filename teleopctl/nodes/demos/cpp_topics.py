"""Talker and listener of ``demo_nodes_cpp``, whose components have their texts: a count from one.

A module of their own, since their names are those of ``demo_nodes_py``.
"""

from __future__ import annotations

from teleopctl.nodes.components.demos import ListenerComponent, TalkerComponent
from teleopctl.nodes.demos.running import run


def talker(args: list[str] | None = None) -> None:
    """Run the node ``demo_nodes_cpp talker``."""
    run(TalkerComponent, args)


def listener(args: list[str] | None = None) -> None:
    """Run the node ``demo_nodes_cpp listener``."""
    run(ListenerComponent, args)
