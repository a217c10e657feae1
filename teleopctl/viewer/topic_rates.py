"""Rates of topics, measured once for the panels of all browsers."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from teleopctl.node import TopicMeter, Traffic

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Period of the measurement; panels that ask more often get the last result.
_PERIOD_S = 0.9


class TopicRates:
    """Meter of the topics that any panel measures, see `TopicMeter`.

    Args:
        stage: The viewer's node.
    """

    def __init__(self, stage: Stage) -> None:
        self._meter = TopicMeter(stage.node)
        self._followed: dict[object, frozenset[str]] = {}
        self._traffic: Mapping[str, Traffic] = {}
        self._sampled_s = 0.0

    def follow(self, panel: object, topics: Iterable[str]) -> None:
        """Set the topics that a panel measures; call this again when the graph has changed.

        Args:
            panel: The panel.
            topics: Names of the topics; none to end.
        """
        former, chosen = self._followed.pop(panel, None), frozenset(topics)
        if chosen:
            self._followed[panel] = chosen
        elif former is None:
            return
        self._meter.follow(frozenset().union(*self._followed.values()))

    def sample(self) -> Mapping[str, Traffic]:
        """Return the traffic of all measured topics over the last 5 s."""
        now_s = time.monotonic()
        if now_s - self._sampled_s > _PERIOD_S:
            self._traffic, self._sampled_s = self._meter.sample(), now_s
        return self._traffic
