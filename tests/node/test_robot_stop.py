"""Names of the nodes that hold the robot stopped on ``/stop``."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import Node, StopHolders

Bool = get_message("std_msgs/msg/Bool")


class GraphBehind:
    """Node whose graph has a publisher only after a wait, if at all."""

    def __init__(self, publishers: dict[bytes, str]) -> None:
        self._later = publishers
        self._now: dict[bytes, str] = {}
        self.waited_s: list[float] = []
        self.context = SimpleNamespace(wait_for_change=self._wait_for_change)
        self.callback: Any = None

    def _wait_for_change(self, predicate: Any, timeout_s: float) -> bool:
        self.waited_s.append(timeout_s)
        self._now = self._later
        return bool(predicate())

    def create_subscription(self, _type: object, _topic: str, callback: Any, _qos: object) -> None:
        self.callback = callback

    def get_publishers_info_by_topic(self, _topic: str) -> list[SimpleNamespace]:
        return [
            SimpleNamespace(endpoint_gid=list(gid), node_namespace="/", node_name=name)
            for gid, name in self._now.items()
        ]


@pytest.mark.parametrize(
    ("publishers", "name"),
    [({b"\1": "button"}, "/button"), ({}, "a node that is not in the graph")],
)
def test_a_holder_is_named_when_the_graph_has_it(publishers: dict[bytes, str], name: str) -> None:
    node = GraphBehind(publishers)
    changes: list[tuple[str, ...]] = []
    holders = StopHolders(cast(Node, node), changes.append)
    node.callback(Bool(data=True), {"publisher_gid": [1]})
    # Those who obey do not wait for the name.
    assert changes == [("a node that is not in the graph",)]
    assert holders.name_all(0.25) == holders.names == (name,)
    assert node.waited_s == [0.25]
