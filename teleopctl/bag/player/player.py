"""A player: a node that plays bags, and that others control by services."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Self

from teleopctl.bag.player.options import PlayOptions
from teleopctl.bag.player.playback import BagPath, Playback
from teleopctl.bag.player.services import PlayerServices
from teleopctl.bag.records import BagMessage

if TYPE_CHECKING:
    from teleopctl.node import Node


class Player(Playback):
    """Player of one bag, or of several merged by time, with rosbag2's services.

    The node gets rosbag2's services to control it, which need an executor that spins the node;
    playing does not. A program may call the methods of the same names, from any thread.

    Example:
        ```python
        with Player(node, "my_bag", PlayOptions(rate=2.0)) as player:
            player.play()
            player.wait()
        ```

    Args:
        node: The node that publishes; it is the caller's. Remappings are the node's.
        bags: A bag's path, or several, each with its storage where the path does not tell.
        options: How they are played.
        played: Called on the playing thread with each message that was sent.

    Raises:
        NotFoundError: A bag does not exist.
        InvalidFileError: One cannot be read.
    """

    def __init__(
        self,
        node: Node,
        bags: str | Path | Sequence[BagPath],
        options: PlayOptions | None = None,
        *,
        played: Callable[[BagMessage], object] = lambda _: None,
    ) -> None:
        super().__init__(node, bags, options or PlayOptions(), played)
        self._services = PlayerServices(node, self)

    def close(self) -> None:
        """Stop, close the bags, and destroy the player's publishers and services."""
        self._services.close()
        super().close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
