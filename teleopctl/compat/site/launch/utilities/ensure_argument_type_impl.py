"""``launch.utilities.ensure_argument_type_impl``."""

from __future__ import annotations

from collections.abc import Iterable


# object: callers may pass anything, which is checked.
def ensure_argument_type(
    argument: object,
    types: type | Iterable[type],
    argument_name: str,
    caller: str | None = None,
) -> None:
    """Raise if an argument is not of the given types.

    Args:
        argument: The argument.
        types: The types, one or several.
        argument_name: Its name.
        caller: Name of the called function, or None.

    Raises:
        TypeError: The argument has none of the types, or another argument is of a wrong type.
    """
    own = "ensure_argument_type()"
    if not isinstance(types, type | Iterable):
        raise _wrong(own, "types", "type, collections.abc.Iterable of type", types)
    if not isinstance(argument_name, str):
        raise _wrong(own, "argument_name", "str", argument_name)
    if caller is not None and not isinstance(caller, str):
        raise _wrong(own, "caller", "str, None", caller)
    allowed = tuple(types) if isinstance(types, Iterable) else (types,)
    if not isinstance(argument, allowed):
        raise _wrong(caller, argument_name, ", ".join(map(str, allowed)), argument)


def _wrong(caller: str | None, name: str, expected: str, given: object) -> TypeError:
    begin = "Expected" if caller is None else f"'{caller}' expected"
    return TypeError(
        f"{begin} '{name}' to be one of [{expected}], but got '{given}' of type '{type(given)}'"
    )
