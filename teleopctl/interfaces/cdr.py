"""Messages to bytes and back: plain CDR in the encapsulation that ROS 2 uses.

Received bytes are not trusted: whatever they hold, the result is a message or a TeleopctlError.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, TypeVar

from rosbags.serde import SerdeError

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.codec import Codec, Codecs
from teleopctl.interfaces.convert import DTYPES, NumberArray, converter
from teleopctl.interfaces.message import Message, wire_name
from teleopctl.interfaces.store import get_message

if TYPE_CHECKING:
    from teleopctl.interfaces.definition import Field

MessageType = TypeVar("MessageType")

_HEADER_SIZE = 4
_BIG_ENDIAN, _LITTLE_ENDIAN = b"\0\0", b"\0\1"
_MAXIMUM_PADDING = 3

_CODECS = Codecs(get_message)
_by_class: dict[type[Any], Codec] = {}


def serialize(message: Any) -> bytearray:
    """Return a message as little-endian CDR with its four bytes of encapsulation.

    A block of numbers is copied once, into the result.

    Raises:
        TeleopctlError: A field holds what its type cannot; the message names the field.
    """
    codec = _by_class.get(type(message)) or _codec(type(message))
    try:
        size = _HEADER_SIZE + codec.getsize_cdr(0, message, _CODECS)  # type: ignore[arg-type]
        data = bytearray(size)
        data[1] = 1
        end = codec.serialize_cdr_le(
            memoryview(data)[_HEADER_SIZE:],
            0,
            message,
            _CODECS,  # type: ignore[arg-type] # has what generated code uses of a type store
        )
    except (SerdeError, struct.error, ValueError, TypeError, LookupError, AttributeError) as error:
        raise _unserializable(message, error) from error
    if end + _HEADER_SIZE != size:
        raise TeleopctlError(f"{message.TYPE_NAME} changed while it was serialised")
    return data


def deserialize(
    data: bytes | bytearray | memoryview, message_class: type[MessageType]
) -> MessageType:
    """Return the message that bytes hold.

    Blocks of numbers are not copied: the message keeps ``data`` alive and refers to it until such
    a field is read.

    Args:
        data: CDR of either byte order with its four bytes of encapsulation.
        message_class: The class of the message.

    Raises:
        TeleopctlError: The bytes are not a message of that class.
    """
    codec = _by_class.get(message_class) or _codec(message_class)
    order = data[:2]
    try:
        if order == _LITTLE_ENDIAN:
            read = codec.deserialize_cdr_le
        elif order == _BIG_ENDIAN:
            read = codec.deserialize_cdr_be
        else:
            raise ValueError(f"unknown encapsulation {bytes(data[:4]).hex()}")
        content = memoryview(data)[_HEADER_SIZE:]
        message, end = read(content, 0, codec.cls, _CODECS)  # type: ignore[arg-type]
        if end > len(content):
            raise ValueError("it ends too early")
        if len(content) - end > _MAXIMUM_PADDING:
            raise ValueError(f"{len(content) - end} bytes are left over")
    except (SerdeError, struct.error, ValueError, OverflowError, MemoryError) as error:
        name = getattr(message_class, "TYPE_NAME", message_class.__name__)
        raise TeleopctlError(
            f"{len(data)} bytes are not a message of type {name}: {error}"
        ) from error
    return message  # type: ignore[return-value] # made by the class that was passed


def as_numpy(message: Any, field: str) -> NumberArray:
    """Return an array or sequence of numbers as a numpy array, without a copy where possible.

    The result may be read-only, and while it refers to an ``array.array`` that cannot be resized.

    Raises:
        TeleopctlError: The message has no such field, or it does not hold numbers.
    """
    for candidate in message.__definition__.fields:
        if candidate.attribute == field:
            if candidate.type.shape and candidate.type.base in DTYPES:
                view: NumberArray = getattr(message, wire_name(candidate))
                return view
            raise TeleopctlError(f"Field {field!r} of {message.TYPE_NAME} holds no numbers")
    raise TeleopctlError(f"{message.TYPE_NAME} has no field {field!r}")


def _codec(message_class: type[Any]) -> Codec:
    if not (isinstance(message_class, type) and issubclass(message_class, Message)):
        raise TeleopctlError(f"{message_class!r} is not a message class")
    codec = _by_class[message_class] = _CODECS.get_msgdef(message_class.TYPE_NAME)
    return codec


def _unserializable(message: Message, error: Exception) -> TeleopctlError:
    """Name the field of a message that cannot be serialised."""
    reason = _first_fault(message, "") or str(error)
    return TeleopctlError(f"{message.TYPE_NAME} cannot be serialised: {reason}")


def _first_fault(message: Message, path: str) -> str | None:
    for field in message.__definition__.fields:
        where = f"{path}{field.attribute}"
        if (fault := _fault(message, field, where)) is not None:
            return fault
    return None


def _fault(message: Message, field: Field, where: str) -> str | None:
    try:
        value = getattr(message, field.attribute)
        converter(field.type, get_message)(value)
        if field.type.base == "string":
            for text in [value] if isinstance(value, str) else value:
                text.encode()
    except AttributeError:
        return f"{where} has no value"
    except (TypeError, ValueError) as error:
        return f"{where}: {error}"
    if field.type.is_nested:
        if isinstance(value, Message):
            return _first_fault(value, f"{where}.")
        for index, element in enumerate(value):
            if (fault := _first_fault(element, f"{where}[{index}].")) is not None:
                return fault
    return None
