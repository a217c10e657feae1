"""Cache of the recent messages of a filter."""

from typing import Any

from message_filters.simple_filter import SimpleFilter, time_of
from teleopctl.node import Time

# Any: messages of any type.


class Cache(SimpleFilter):
    """Keeps the newest messages of another filter, and passes them on.

    Args:
        f: The filter that it takes from.
        cache_size: How many messages are remembered.
        allow_headerless: Whether a message without header counts at the time of its arrival.
    """

    def __init__(
        self, f: SimpleFilter, cache_size: int = 1, allow_headerless: bool = False
    ) -> None:
        super().__init__()
        self.cache_size = cache_size
        self.allow_headerless = allow_headerless
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Time] = []
        self.connectInput(f)

    def connectInput(self, f: SimpleFilter) -> None:  # noqa: N802
        """Connect to a filter."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Keep a message and pass it on."""
        time = time_of(msg, self.allow_headerless, "message_filters_cache")
        if time is None:
            return
        self.cache_times.append(time)
        self.cache_msgs.append(msg)
        if len(self.cache_msgs) > self.cache_size:
            del self.cache_msgs[0], self.cache_times[0]
        self.signalMessage(msg)

    def getInterval(self, from_stamp: Time, to_stamp: Time) -> list[Any]:  # noqa: N802
        """Return the messages between two times, both included."""
        assert from_stamp <= to_stamp
        return [m for m, time in self._timed() if from_stamp <= time <= to_stamp]

    def getElemAfterTime(self, stamp: Time) -> Any:  # noqa: N802
        """Return the oldest message that is not older than a time, or None."""
        return next((m for m, time in self._timed() if time >= stamp), None)

    def getElemBeforeTime(self, stamp: Time) -> Any:  # noqa: N802
        """Return the newest message that is not newer than a time, or None."""
        return next((m for m, time in reversed(self._timed()) if time <= stamp), None)

    def getLatestTime(self) -> Time | None:  # noqa: N802
        """Return the time of the newest message, or None."""
        return self.cache_times[-1] if self.cache_times else None

    getLastestTime = getLatestTime  # noqa: N815 -- so it is spelt in Jazzy

    def getOldestTime(self) -> Time | None:  # noqa: N802
        """Return the time of the oldest message, or None."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self) -> Any:  # noqa: N802
        """Return the newest message, or None."""
        return self.cache_msgs[-1] if self.cache_msgs else None

    def _timed(self) -> list[tuple[Any, Time]]:
        return list(zip(self.cache_msgs, self.cache_times, strict=True))
