"""Topics whose type this machine lacks: nodes that use the type explain it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import known_types
from teleopctl.node import add_type_from_graph

if TYPE_CHECKING:
    from teleopctl.node import Node


@dataclass(slots=True, eq=False)
class _Wish:
    """What begins once a type is known, and how that is ended."""

    type_name: str
    begin: Callable[[], Callable[[], None]]
    end: Callable[[], None] | None = None


class UnknownTypes:
    """Requests the definitions of unknown message types, and then starts what needs them.

    Args:
        node: Who asks.
        work: Does something that takes long in another thread, as `Stage.work`.
    """

    # Any: what a task returns.
    def __init__(
        self,
        node: Node,
        work: Callable[[Callable[[], Any], Callable[[Any], object]], object],
    ) -> None:
        self._node = node
        self._work = work
        self._wishes: list[_Wish] = []
        # Who used a type when it was last asked about.
        self._asked: dict[str, frozenset[str]] = {}

    def when_known(
        self, type_name: str, begin: Callable[[], Callable[[], None]]
    ) -> Callable[[], None]:
        """Call a function as soon as a type is known.

        Args:
            type_name: Full name of a message.
            begin: Called on the node's thread; it returns what ends it.

        Returns:
            What ends it, or the wait for it.
        """
        wish = _Wish(type_name, begin)
        self._wishes.append(wish)
        self.look()

        def end() -> None:
            if wish in self._wishes:
                self._wishes.remove(wish)
            if wish.end is not None:
                wish.end()
                wish.end = None

        return end

    def look(self) -> None:
        """Request missing definitions from new users of a type; called on graph changes."""
        if not self._wishes:
            return
        graph = self._node.graph()
        for type_name in {wish.type_name for wish in self._wishes}:
            users = frozenset(
                e.full_name
                for e in graph.endpoints
                if e.type_name == type_name and graph.servers(f"{e.full_name}/get_type_description")
            )
            if users and users != self._asked.get(type_name):
                self._asked[type_name] = users
                self._ask(type_name)

    def _ask(self, type_name: str) -> None:
        graph = self._node.graph()
        self._work(
            lambda: add_type_from_graph(self._node, type_name, graph),
            lambda result: self._asked_for(type_name, result),
        )

    # Any: None, or what went wrong.
    def _asked_for(self, type_name: str, result: Any) -> None:
        if isinstance(result, BaseException):
            self._node.get_logger().warning(f"{type_name} is not known here: {result}")
        if known_types().find(type_name) is None:
            return
        for wish in [one for one in self._wishes if one.type_name == type_name]:
            self._wishes.remove(wish)
            wish.end = wish.begin()
