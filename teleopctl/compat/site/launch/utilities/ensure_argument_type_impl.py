"""``launch.utilities.ensure_argument_type_impl``."""

from __future__ import annotations

from collections.abc import Iterable


# object: whatever a user hands over, which may be wrong.
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
        caller: Who was called with it, or None.

    Raises:
        TypeError: It is of none of them, or what is given here is of a wrong type itself.
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
