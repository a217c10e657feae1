"""Plotted fields of a recording: their samples are read from its file, the whole of it at once."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from teleopctl.interfaces import NumericField, field_reader, numeric_fields
from teleopctl.viewer.panels.plots.series import Floats, MessageTimes, Series, number_of

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage


# Any: messages, whose classes are created from definitions at run time.
class Recording(Protocol):
    """A played recording whose messages can also be read from its file."""

    @property
    def start_s(self) -> float:
        """Time of the first message in seconds since the epoch."""

    @property
    def end_s(self) -> float:
        """Time of the last message in seconds since the epoch."""

    @property
    def topics(self) -> Collection[str]:
        """Names of the topics that can be read."""

    def messages(self, topic: str) -> Iterator[tuple[float, Any]]:
        """Yield time of receipt (s since the epoch) and content of each message of a topic."""


class _ReadFields(NamedTuple):
    """Fields of all messages of a topic: times (s), values by path, and one message."""

    times: Floats
    values: dict[str, Floats]
    example: Any


class PlottedBagTopic:
    """Topic of a recording for plots; has the interface of `PlottedTopic`.

    Nothing is subscribed to: the samples do not depend on where the recording is played, how fast,
    and whether its time jumps.

    Args:
        stage: The viewer's node.
        recording: The recording.
        name: Name of the topic.

    Attributes:
        name: Name of the topic.
        series: Read samples by path of the field.
        newest: A message of the topic, once one has been read.
        received_s: Infinite, since a recorded topic does not fall silent.
    """

    received_s = math.inf

    def __init__(self, stage: Stage, recording: Recording, name: str) -> None:
        self.name = name
        self.series: dict[str, Series] = {}
        self.newest: Any = None
        self._stage, self._recording = stage, recording
        self._missing: list[str] = []
        self._is_reading = False

    def subscribe(self) -> None:
        """Do nothing: the samples are read from the file."""

    def unsubscribe(self) -> None:
        """Do nothing: there is no subscription."""

    def clear(self) -> None:
        """Do nothing: the samples are those of the file."""

    def add_field(self, path: str) -> Series:
        """Read the samples of a field in the background; return the field's `Series`."""
        if path not in self.series:
            self.series[path] = Series()
            self._missing.append(path)
            self._read_missing()
        return self.series[path]

    def remove_field(self, path: str) -> None:
        """Drop the samples of a field."""
        self.series.pop(path, None)

    def fields(self) -> list[NumericField]:
        """Return the numeric fields of a message of the topic; empty before one has been read."""
        return [] if self.newest is None else numeric_fields(self.newest)

    def _read_missing(self) -> None:
        paths = [path for path in self._missing if path in self.series]
        if self._is_reading or not paths:
            return
        self._missing, self._is_reading = [], True
        self._stage.run_in_background(lambda: self._read(paths), self._take)

    def _read(self, paths: Sequence[str]) -> _ReadFields:
        readers = {path: field_reader(path) for path in paths}
        of_message = MessageTimes()
        times: list[float] = []
        values: dict[str, list[float]] = {path: [] for path in paths}
        example = None
        for received_s, message in self._recording.messages(self.name):
            example = message
            times.append(of_message.time_of(message, received_s))
            for path, read in readers.items():
                values[path].append(number_of(read, message))
        order = np.argsort(np.array(times), kind="stable")
        return _ReadFields(
            np.array(times)[order],
            {path: np.array(some)[order] for path, some in values.items()},
            example,
        )

    # Any: the result, or the exception.
    def _take(self, result: Any) -> None:
        self._is_reading = False
        if isinstance(result, Exception):
            raise result
        self.newest = result.example
        for path, values in result.values.items():
            if path in self.series:
                self.series[path].fill(result.times, values)
        self._read_missing()
