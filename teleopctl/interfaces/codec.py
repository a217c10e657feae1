"""The functions that turn a message type into CDR and back, made by rosbags' generators."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rosbags.interfaces import Nodetype
from rosbags.serde.cdr import (
    generate_deserialize_cdr,
    generate_getsize_cdr,
    generate_serialize_cdr,
)

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.definition import FieldType, Shape
from teleopctl.interfaces.message import make_builder, wire_name

if TYPE_CHECKING:
    from rosbags.interfaces import CDRDeser, CDRSer

    from teleopctl.interfaces.message import Message

# On the wire these are bytes without a sign; rosbags takes ``byte`` for a signed number.
_UNSIGNED = {"byte": "uint8", "char": "uint8"}


class Codec:
    """What rosbags' generated code wants to know about one type.

    The names of the attributes are those of ``rosbags.interfaces.Msgdef``. Each function is
    generated when it is first called for: most types are only ever sent or only ever received.
    """

    def __init__(self, cls: type[Message], codecs: Codecs) -> None:
        self._codecs = codecs
        fields = cls.__definition__.wire_fields
        descriptions = [_description(cls.TYPE_NAME, field.type) for field in fields]
        self._slots = [
            (f"_{field.attribute}", description)
            for field, description in zip(fields, descriptions, strict=True)
        ]
        self.fields: Any = [
            (wire_name(field), description)
            for field, description in zip(fields, descriptions, strict=True)
        ]
        self.cls: Any = make_builder(cls)
        self.getsize_cdr, self.size_cdr = generate_getsize_cdr(
            self._slots,  # type: ignore[arg-type] # plain tuples, as in rosbags' own tables
            codecs,  # type: ignore[arg-type] # has what the generators use of a type store
        )

    @cached_property
    def serialize_cdr_le(self) -> CDRSer:
        """Write a message, little-endian."""
        return generate_serialize_cdr(self.fields, self._codecs, "le")  # type: ignore[arg-type]

    @cached_property
    def deserialize_cdr_le(self) -> CDRDeser:
        """Read a little-endian message."""
        return generate_deserialize_cdr(self.fields, self._codecs, "le")  # type: ignore[arg-type]

    @cached_property
    def deserialize_cdr_be(self) -> CDRDeser:
        """Read a big-endian message."""
        return generate_deserialize_cdr(self.fields, self._codecs, "be")  # type: ignore[arg-type]


class Codecs:
    """The codecs of all types in use; stands in for rosbags' type store in generated code."""

    max_sequence_length = 2**32 - 1

    def __init__(self, message_class: Callable[[str], type[Message]]) -> None:
        self._message_class = message_class
        self._codecs: dict[str, Codec] = {}
        self._lock = threading.RLock()

    def get_msgdef(self, type_name: str) -> Codec:
        """Return the codec of a type.

        Raises:
            TeleopctlError: The type is unknown, or has wide strings.
        """
        found = self._codecs.get(type_name)
        if found is None:
            with self._lock:
                found = self._codecs.get(type_name)
                if found is None:
                    found = Codec(self._message_class(type_name), self)
                    self._codecs[type_name] = found
        return found


def _description(type_name: str, kind: FieldType) -> tuple[Nodetype, Any]:
    if kind.base == "wstring":
        raise TeleopctlError(f"{type_name} has a wide string, which cannot be sent or received")
    element: tuple[Nodetype, Any] = (
        (Nodetype.NAME, kind.base)
        if kind.is_nested
        else (Nodetype.BASE, (_UNSIGNED.get(kind.base, kind.base), kind.string_capacity))
    )
    if kind.shape is Shape.SINGLE:
        return element
    node = Nodetype.ARRAY if kind.shape is Shape.ARRAY else Nodetype.SEQUENCE
    return (node, (element, kind.capacity))
