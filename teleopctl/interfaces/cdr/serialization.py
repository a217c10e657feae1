"""Serialization of messages: plain CDR in the encapsulation that ROS 2 uses.

Received bytes are not trusted: any bytes result in a message or a TeleopctlError.
"""

from __future__ import annotations

import struct

from teleopctl.base.typed import TYPE_CHECKING, Any, TypeVar
from teleopctl.errors import InvalidMessageError, TeleopctlError
from teleopctl.interfaces.blocks import BLOCK_CODES, to_numpy
from teleopctl.interfaces.cdr.codec import Codecs, Reader, Writer
from teleopctl.interfaces.cdr.layout import HEADER_SIZE
from teleopctl.interfaces.convert import converter
from teleopctl.interfaces.message import Message, stored
from teleopctl.interfaces.store import get_message

if TYPE_CHECKING:
    from teleopctl.interfaces.blocks import NumberArray
    from teleopctl.interfaces.definition import Field

MessageType = TypeVar("MessageType")

_BIG_ENDIAN, _LITTLE_ENDIAN = b"\0\0", b"\0\1"
_HEADER = _LITTLE_ENDIAN + bytes(HEADER_SIZE - 2)

_CODECS = Codecs(get_message)
# Codecs of classes from definition texts, whose nested types are not the types of this process.
_codecs_apart: dict[type[Any], Codecs] = {}
_writers: dict[type[Any], Writer] = {}
_little_readers: dict[type[Any], Reader] = {}
_big_readers: dict[type[Any], Reader] = {}


def serialize(message: Message) -> bytearray:
    """Return a message as a bytearray: little-endian CDR with encapsulation header.

    A block of numbers is copied once, into the result.

    Raises:
        InvalidMessageError: A value does not fit the type of its field; the error names the field.
    """
    write = _writers.get(type(message)) or _find_writer(type(message))
    data = bytearray(_HEADER)
    try:
        write(data, message)
    except (struct.error, ValueError, TypeError, LookupError, AttributeError) as error:
        raise _unserializable(message, error) from error
    return data


def deserialize(
    data: bytes | bytearray | memoryview, message_class: type[MessageType]
) -> MessageType:
    """Return a message of the given class, parsed from CDR of either byte order.

    Bytes after the message are ignored: ROS 2 pads some messages by up to 64 bytes, when it
    serializes them in advance.

    Blocks of numbers are not copied: the message refers to ``data``, and keeps it alive, until the
    fields with blocks are read.

    Args:
        data: CDR of either byte order, with the four bytes of encapsulation.
        message_class: Class of the message.

    Raises:
        InvalidMessageError: The bytes are not a message of that class.
    """
    if type(data) is not bytes and type(data) is not bytearray:
        data = memoryview(data).cast("B")
    size = len(data)
    order = data[:2]
    try:
        if order == _LITTLE_ENDIAN:
            read = _little_readers.get(message_class) or _find_reader(message_class, True)
        elif order == _BIG_ENDIAN:
            read = _big_readers.get(message_class) or _find_reader(message_class, False)
        else:
            raise ValueError(f"unknown encapsulation {bytes(data[:HEADER_SIZE]).hex()}")
        message, end = read(data, memoryview(data), HEADER_SIZE, size)
        if end > size:
            raise ValueError("it ends too early")
    except (struct.error, ValueError, OverflowError, MemoryError) as error:
        raise _unreadable(size, message_class, error) from error
    return message  # type: ignore[no-any-return] # made by the class that was passed


def set_codecs(message_class: type[Message], codecs: Codecs) -> None:
    """Set the codecs with which messages of a class and its nested classes are read and written."""
    _codecs_apart[message_class] = codecs


# Any, in both functions: message classes are made from definitions at run time.
def class_within(message_class: type[Any], type_name: str) -> type[Any]:
    """Return the class of a nested message type, as the outer message class defines it.

    Raises:
        InvalidMessageError: The type does not exist.
    """
    return _codecs_of(message_class).message_class(type_name)


def check_readable(message_class: type[Any]) -> None:
    """Raise InvalidMessageError if messages of a class cannot be deserialized.

    Raises:
        InvalidMessageError: Messages of the class cannot be deserialized; the error has the reason.
    """
    _find_reader(message_class, True)


def as_numpy(message: Message, field: str) -> NumberArray:
    """Return a message's array or sequence field as a numpy array, without a copy where possible.

    The result may be read-only. An ``array.array`` to which the result refers cannot be resized.

    Raises:
        InvalidMessageError: The message has no such field, or the field does not hold numbers.
    """
    for candidate in message.__definition__.fields:
        if candidate.attribute == field:
            if candidate.type.shape and candidate.type.base in BLOCK_CODES:
                return to_numpy(candidate.type.base, stored(message, candidate))
            raise InvalidMessageError(f"Field {field!r} of {message.TYPE_NAME} holds no numbers")
    raise InvalidMessageError(f"{message.TYPE_NAME} has no field {field!r}")


def _find_writer(message_class: type[Any]) -> Writer:
    _check_class(message_class)
    write = _writers[message_class] = _codecs_of(message_class).writer(message_class.TYPE_NAME)
    return write


def _find_reader(message_class: type[Any], is_little: bool) -> Reader:
    _check_class(message_class)
    readers = _little_readers if is_little else _big_readers
    read = readers[message_class] = _codecs_of(message_class).reader(
        message_class.TYPE_NAME, is_little
    )
    return read


def _codecs_of(message_class: type[Any]) -> Codecs:
    return _codecs_apart.get(message_class, _CODECS)


def _check_class(message_class: object) -> None:
    if not (isinstance(message_class, type) and issubclass(message_class, Message)):
        raise InvalidMessageError(f"{message_class!r} is not a message class")


def _unreadable(size: int, message_class: type[Any], error: Exception) -> TeleopctlError:
    _check_class(message_class)
    reason = "it ends too early" if isinstance(error, struct.error) else str(error)
    return InvalidMessageError(
        f"{size} bytes are not a message of type {message_class.TYPE_NAME}: {reason}"
    )


def _unserializable(message: Message, error: Exception) -> TeleopctlError:
    """Return an error that names the field of a message that cannot be serialised."""
    reason = _first_fault(message, "") or str(error)
    return InvalidMessageError(f"{message.TYPE_NAME} cannot be serialised: {reason}")


def _first_fault(message: Message, path: str) -> str | None:
    for field in message.__definition__.fields:
        where = f"{path}{field.attribute}"
        if (fault := _fault(message, field, where)) is not None:
            return fault
    return None


def _fault(message: Message, field: Field, where: str) -> str | None:
    try:
        value = getattr(message, field.attribute)
        converter(field.type, _codecs_of(type(message)).message_class)(value)
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
