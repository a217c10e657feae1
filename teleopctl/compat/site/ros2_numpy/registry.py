"""``ros2_numpy.registry``. Which types can be converted."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

# Any: messages of any type, and the corresponding arrays.
_Function = TypeVar("_Function", bound=Callable[..., Any])

_to_numpy: dict[tuple[type[Any], bool], Callable[..., Any]] = {}
_from_numpy: dict[tuple[type[Any], bool], Callable[..., Any]] = {}


def converts_to_numpy(msgtype: type[Any], plural: bool = False) -> Callable[[_Function], _Function]:
    """Register a function that converts messages of a type, or a list of them, to an array."""

    def register(function: _Function) -> _Function:
        _to_numpy[msgtype, plural] = function
        return function

    return register


def converts_from_numpy(
    msgtype: type[Any], plural: bool = False
) -> Callable[[_Function], _Function]:
    """Register a function that converts an array to a message of a type, or a list of them."""

    def register(function: _Function) -> _Function:
        _from_numpy[msgtype, plural] = function
        return function

    return register


def numpify(msg: Any, *args: Any, **kwargs: Any) -> Any:
    """Return a message, or a list of messages, as an array; None for None.

    Raises:
        ValueError: There is no conversion for the type, or the list is empty.
    """
    if msg is None:
        return None
    convert = _to_numpy.get((type(msg), False))
    if convert is None and isinstance(msg, Sequence):
        if not msg:
            raise ValueError("Cannot determine the type of an empty Collection")
        convert = _to_numpy.get((type(msg[0]), True))
    if convert is None:
        raise ValueError(
            f"Unable to convert message {type(msg).__name__} - only supports {_named(_to_numpy)}"
        )
    return convert(msg, *args, **kwargs)


def msgify(msg_type: type[Any], numpy_obj: Any, *args: Any, **kwargs: Any) -> Any:
    """Return an array as a message of a type; with ``plural=True`` as a list of them.

    Raises:
        ValueError: There is no conversion for the type.
    """
    convert = _from_numpy.get((msg_type, kwargs.pop("plural", False)))
    if convert is None:
        raise ValueError(
            f"Unable to build message {msg_type.__name__} - only supports {_named(_from_numpy)}"
        )
    return convert(numpy_obj, *args, **kwargs)


def _named(known: dict[tuple[type[Any], bool], Callable[..., Any]]) -> str:
    return ", ".join(kind.__name__ + ("[]" if plural else "") for kind, plural in known)
