"""Samples of all plotted fields, collected once for the plots of all browsers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from teleopctl.viewer.panels.plots.recorded import PlottedBagTopic, Recording
from teleopctl.viewer.panels.plots.series import (
    MOST_OF_ALL,
    MOST_SAMPLES,
    PlottedTopic,
    Series,
)

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage


class CollectedSamples:
    """The plotted topics with their samples, which the plots of all browsers share.

    So a field that two browsers plot is received once, the plots of a page that is loaded again
    have their history, and all samples share one limit of memory. A field that no panel plots any
    more is dropped, and so is a topic without fields.

    Args:
        stage: The viewer's node.

    Attributes:
        topics: The plotted topics by name.
        recording: The played recording, from whose file plots are read; None for none.
    """

    def __init__(self, stage: Stage) -> None:
        self.topics: dict[str, PlottedTopic | PlottedBagTopic] = {}
        self.recording: Recording | None = None
        self._stage = stage
        # The panels of plots: those that are shown, and the fields (topic, path) of each.
        self._shown: set[object] = set()
        self._plotted: dict[object, set[tuple[str, str]]] = {}

    def begin(self, panel: object) -> None:
        """Subscribe to the topics for a panel that is shown; the first one drops old samples.

        Args:
            panel: The panel.
        """
        if not self._shown:
            self.clear()
        self._shown.add(panel)
        self.subscribe()

    def clear(self) -> None:
        """Drop all samples."""
        for topic in self.topics.values():
            topic.clear()

    def end(self, panel: object) -> None:
        """Unsubscribe from the topics if no other panel is shown; the samples stay.

        Args:
            panel: The panel.
        """
        self._shown.discard(panel)
        if not self._shown:
            for topic in self.topics.values():
                topic.unsubscribe()

    def subscribe(self) -> None:
        """Subscribe as the publishers now need it, see `PlottedTopic.subscribe`."""
        if self._shown:
            for topic in self.topics.values():
                topic.subscribe()

    def add(self, panel: object, topic: str, path: str) -> Series:
        """Return the samples of a field, which a panel plots from now on.

        Args:
            panel: The panel.
            topic: Name of the topic.
            path: Path of the field, such as ``position[0]``.
        """
        plotted = self.topics.get(topic)
        if plotted is None:
            recording = self.recording
            if recording is not None and topic in recording.topics:
                plotted = PlottedBagTopic(self._stage, recording, topic)
            else:
                plotted = PlottedTopic(self._stage, topic)
            self.topics[topic] = plotted
            if self._shown:
                plotted.subscribe()
        self._plotted.setdefault(panel, set()).add((topic, path))
        series = plotted.add_field(path)
        self._share_memory()
        return series

    def keep(self, panel: object, fields: Iterable[tuple[str, str]]) -> None:
        """Drop what a panel does not plot any more, unless another panel does.

        Args:
            panel: The panel.
            fields: The fields that it still plots, each a topic and a path.
        """
        self._plotted[panel] = set(fields)
        if not self._plotted[panel]:
            del self._plotted[panel]
        wanted = set().union(*self._plotted.values())
        for name, topic in list(self.topics.items()):
            for path in [path for path in topic.series if (name, path) not in wanted]:
                topic.remove_field(path)
            if not topic.series:
                self.topics.pop(name).unsubscribe()
        self._share_memory()

    def _share_memory(self) -> None:
        """Share the memory for samples among all series."""
        series = [one for topic in self.topics.values() for one in topic.series.values()]
        limit = min(MOST_SAMPLES, MOST_OF_ALL // max(len(series), 1))
        for one in series:
            one.set_limit(limit)
