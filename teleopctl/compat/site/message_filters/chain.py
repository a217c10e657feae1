"""Chain of filters."""

from typing import Any

from message_filters.simple_filter import SimpleFilter

# Any: messages of any type.


class Chain(SimpleFilter):
    """Passes messages through filters in turn; its output is that of the last one.

    Args:
        message_filter: The filter that it takes from; None where `add` is called instead.
    """

    def __init__(self, message_filter: SimpleFilter | None = None) -> None:
        super().__init__()
        self._links: list[tuple[Any, int]] = []
        self.incoming_connection: int | None = None
        if message_filter is not None:
            self.connectInput(message_filter)

    def connectInput(self, message_filter: SimpleFilter) -> None:  # noqa: N802
        """Connect to a filter.

        Raises:
            RuntimeError: It takes those of one already.
        """
        if self.incoming_connection is not None:
            raise RuntimeError("the chain has an input already")
        self.incoming_connection = message_filter.registerCallback(self.add)

    # Any: a filter that has ``add``, as Cache.
    def addFilter(self, message_filter: Any) -> int:  # noqa: N802
        """Append a filter to the chain; return its number for `getFilter`."""
        if self._links:
            last, connection = self._links[-1]
            last.unregisterCallback(connection)
            self._links[-1] = (last, last.registerCallback(message_filter.add))
        self._links.append((message_filter, message_filter.registerCallback(self.signalMessage)))
        return len(self._links) - 1

    def getFilter(self, index: int) -> Any:  # noqa: N802
        """Return a filter by its number.

        Raises:
            KeyError: There is none of that number.
        """
        if not 0 <= index < len(self._links):
            raise KeyError(index)
        return self._links[index][0]

    def add(self, message: Any) -> None:
        """Pass a message through the chain."""
        if self._links:
            self._links[0][0].add(message)
        else:
            self.signalMessage(message)
