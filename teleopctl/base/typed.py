"""Stand-ins for names of ``typing`` that are needed at run time, without importing it.

The import of ``typing`` takes 6 ms, as long as a query of the graph, for objects that only type
checkers read. This module replaces the few names that are used at run time; type checkers see the
real ones.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import (
        Annotated as Annotated,
        Any as Any,
        ClassVar as ClassVar,
        Final as Final,
        Generic as Generic,
        Literal as Literal,
        NamedTuple as NamedTuple,
        Protocol as Protocol,
        Self as Self,
        TypeAlias as TypeAlias,
        TypedDict as TypedDict,
        TypeVar as TypeVar,
        cast as cast,
        overload as overload,
    )
else:
    from operator import itemgetter

    class Any:
        """Any value."""

    # Used in annotations only, which are not read at run time.
    ClassVar = Final = Literal = Self = TypeAlias = Any

    class Annotated:
        """A type with metadata: ``Annotated[bool, Option("--all", help="…")]``."""

        __slots__ = ("__metadata__", "__origin__")

        def __class_getitem__(cls, parts: tuple[object, ...]) -> Annotated:
            annotated = cls()
            annotated.__origin__, *metadata = parts
            annotated.__metadata__ = tuple(metadata)
            return annotated

    class TypeVar:
        """Type variable, which only has a name."""

        def __init__(self, name: str, **_: object) -> None:
            self.__name__ = name

        def __or__(self, _: object) -> TypeVar:
            return self

        __ror__ = __or__

    class Generic:
        """Base of generic classes; at run time ``Publisher[String]`` is ``Publisher``."""

        __class_getitem__ = classmethod(type(list[int]))

    class Protocol(Generic):
        """Base of protocol classes, which are not checked at run time."""

    class _Record(tuple):
        """Methods of all named tuples, which `collections.namedtuple` compiles for each class."""

        __slots__ = ()

        def __new__(cls, *values: object, **named: object) -> _Record:
            if named or len(values) != len(cls._fields):
                values = cls._complete(values, named)
            return tuple.__new__(cls, values)

        @classmethod
        def _complete(cls, values: tuple[object, ...], named: dict[str, object]) -> list[object]:
            given = dict(zip(cls._fields, values, strict=False))
            every = {**cls._field_defaults, **given, **named}
            if len(given) < len(values) or given.keys() & named or every.keys() != {*cls._fields}:
                raise TypeError(f"{cls.__name__} has the fields {', '.join(cls._fields)}")
            return [every[field] for field in cls._fields]

        @classmethod
        def _make(cls, values: tuple[object, ...]) -> _Record:
            return cls(*values)

        def _replace(self, **changed: object) -> _Record:
            return type(self)(**{**self._asdict(), **changed})

        def _asdict(self) -> dict[str, object]:
            return dict(zip(self._fields, self, strict=True))

        def __getnewargs__(self) -> tuple[object, ...]:
            return tuple(self)

        def __repr__(self) -> str:
            fields = (f"{field}={value!r}" for field, value in self._asdict().items())
            return f"{type(self).__name__}({', '.join(fields)})"

    class _RecordMaker(type):
        def __new__(cls, name: str, bases: tuple[type, ...], body: dict[str, object]) -> type:
            if not bases:
                return super().__new__(cls, name, bases, body)
            fields = tuple(body["__annotations__"])
            body["_field_defaults"] = {field: body[field] for field in fields if field in body}
            body |= {field: property(itemgetter(at)) for at, field in enumerate(fields)}
            body |= {"__slots__": (), "_fields": fields, "__match_args__": fields}
            return type(name, (_Record,), body)

    class NamedTuple(metaclass=_RecordMaker):
        """Tuple with named fields; its module must postpone annotations."""

    TypedDict = dict

    def cast(_type: object, value: object) -> object:
        """Return the value unchanged; type checkers treat it as being of the type."""
        return value

    def overload(function: object) -> object:
        """Return the function unchanged; type checkers read its signature."""
        return function
