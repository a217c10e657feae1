"""Filters that pass a message on only if some of its fields have changed."""

from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

from message_filters.simple_filter import SimpleFilter

# Any, here and below: messages of any type, and the values of their fields.
FieldGetter = Callable[[Any], Any]


class ComparisonHandler:
    """Decides which messages a `ComparisonFilter` passes on."""

    def message_fits(self, message: Any) -> bool:
        """Return whether a message is passed on."""
        raise NotImplementedError

    def do_fields_fit(self, field_a: Any, field_b: Any) -> bool:
        """Return whether the previous and the present value of a field let the message pass."""
        raise NotImplementedError


class CachedComparisonHandler(ComparisonHandler):
    """Handler that compares with the message passed on last; the first one always passes.

    A message passes if `do_fields_fit` returns True for any field.
    """

    def __init__(self) -> None:
        self._field_getters: Sequence[FieldGetter] = ()
        self._last: Any = None

    def message_fits(self, message: Any) -> bool:
        """Return whether a message is passed on, and keep it if so."""
        fits = self._last is None or any(
            self.do_fields_fit(get(self._last), get(message)) for get in self._field_getters
        )
        if fits:
            self._last = message
        return fits


class DeltaCompare(CachedComparisonHandler):
    """Handler that lets a message pass if a field differs from that of the last one.

    Args:
        field_getters: Functions that return a number, a text or a truth value of a message.
    """

    def __init__(self, field_getters: Sequence[FieldGetter]) -> None:
        super().__init__()
        self._field_getters = field_getters

    def do_fields_fit(self, field_a: Any, field_b: Any) -> bool:
        """Return whether two values differ.

        Raises:
            TypeError: One of them is no number, text or truth value.
        """
        for value in (field_a, field_b):
            if not isinstance(value, bool | int | float | str):
                raise TypeError(f"values of type {type(value).__name__} cannot be compared")
        return bool(field_a != field_b)


class ComparisonFilter(SimpleFilter):
    """Passes on the messages that a handler accepts.

    Args:
        comparison_handler: Decides.
        message_filter: The filter that it takes from; None where `add` is called instead.
    """

    def __init__(
        self,
        comparison_handler: ComparisonHandler,
        message_filter: SimpleFilter | None = None,
    ) -> None:
        super().__init__()
        self._comparison_handler = comparison_handler
        self.incoming_connection: int | None = None
        self.connectInput(message_filter)

    def connectInput(self, message_filter: SimpleFilter | None) -> None:  # noqa: N802
        """Connect to a filter.

        Raises:
            RuntimeError: It takes those of one already.
        """
        if self.incoming_connection is not None:
            raise RuntimeError("the filter has an input already")
        if message_filter is not None:
            self.incoming_connection = message_filter.registerCallback(self.add)

    def add(self, message: Any) -> None:
        """Process a message."""
        if self.message_fits(message):
            self.signalMessage(message)

    def message_fits(self, message: Any) -> bool:
        """Return whether a message is passed on."""
        return self._comparison_handler.message_fits(message)


class DeltaFilter(ComparisonFilter):
    """Passes on messages in which one of some fields has changed.

    Args:
        field_getters: Functions that return the fields; see `DeltaCompare`.
        message_filter: As for `ComparisonFilter`.
    """

    def __init__(
        self,
        field_getters: Sequence[FieldGetter],
        message_filter: SimpleFilter | None = None,
    ) -> None:
        super().__init__(DeltaCompare(field_getters), message_filter)


class PathDeltaFilter(DeltaFilter):
    """Passes on messages in which one of some fields has changed.

    Args:
        field_path_list: The fields, as ``pose.position.x``.
        message_filter: As for `ComparisonFilter`.
    """

    def __init__(
        self, field_path_list: Sequence[str], message_filter: SimpleFilter | None = None
    ) -> None:
        super().__init__([_field(path) for path in field_path_list], message_filter)


def _field(path: str) -> FieldGetter:
    get = attrgetter(path)

    def checked(message: Any) -> Any:
        try:
            return get(message)
        except AttributeError as error:
            raise RuntimeError(f"no field {path!r} in the message: {error}") from error

    return checked
