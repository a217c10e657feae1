"""``launch_testing.parametrize``."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from ._marks import IS_PARAMETRIZED, TIMEOUT

# Any: functions of a test description have any arguments and results.
Description = Callable[..., Any]


def parametrize(
    argnames: str, argvalues: Iterable[Any]
) -> Callable[[Description], Callable[[], Iterator[tuple[Description, dict[str, Any]]]]]:
    """Launch a test description once for each of several values.

    Args:
        argnames: Names of the function's arguments, separated by commas.
        argvalues: Their values: tuples, or values of a single argument.
    """
    names = [name.strip() for name in argnames.split(",") if name.strip()]
    values = [value if isinstance(value, tuple) else (value,) for value in argvalues]

    def decorate(
        function: Description,
    ) -> Callable[[], Iterator[tuple[Description, dict[str, Any]]]]:
        @functools.wraps(function)
        def descriptions() -> Iterator[tuple[Description, dict[str, Any]]]:
            for value in values:
                # A value too few leaves an argument out, which `validate` reports by its name.
                arguments = dict(zip(names, value, strict=False))
                bound = functools.partial(function, **arguments)
                yield functools.update_wrapper(bound, function), arguments

        setattr(descriptions, IS_PARAMETRIZED, True)
        if hasattr(function, TIMEOUT):
            setattr(descriptions, TIMEOUT, getattr(function, TIMEOUT))
        return descriptions

    return decorate
