"""``ros2cli.node.strategy``. Node of a command-line tool, with or without a daemon."""

import argparse

from ros2cli.node.direct import DirectNode, add_arguments as add_direct_arguments

__all__ = ["NodeStrategy", "add_arguments"]


class NodeStrategy(DirectNode):
    """Node of a command-line tool; reads the graph directly, since that needs no daemon.

    Args:
        args: Parsed command line, as for a `DirectNode`.
    """

    def __init__(self, args: object) -> None:
        super().__init__(args)

    @property
    def daemon_node(self) -> None:
        """None: there is no daemon with a copy of the graph."""

    @property
    def direct_node(self) -> DirectNode:
        """This node."""
        return self


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `NodeStrategy` to a command line."""
    add_direct_arguments(parser)
    parser.add_argument(
        "--no-daemon", action="store_true", help="Accepted: the graph is always read directly."
    )
