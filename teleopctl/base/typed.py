"""Stand-ins for names of ``typing`` and of other modules, which run without importing these.

The import of ``typing`` takes 6 ms, as long as a query of the graph, for objects that only type
checkers read; ``collections``, ``contextlib``, ``enum`` and ``functools`` take 3 ms for a few small
functions. This module replaces the names that short commands use at run time; type checkers see the
real ones.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import (
        Callable as Callable,
        Collection as Collection,
        Iterable as Iterable,
        Iterator as Iterator,
        Mapping as Mapping,
        Sequence as Sequence,
    )
    from contextlib import contextmanager as contextmanager, suppress as suppress
    from enum import IntEnum as IntEnum, StrEnum as StrEnum
    from functools import cache as cache
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
        TypeGuard as TypeGuard,
        TypeVar as TypeVar,
        cast as cast,
        overload as overload,
    )
else:
    # Python has loaded these modules; it has not loaded operator, and collections above its abc.
    from _collections_abc import (
        Callable as Callable,
        Collection as Collection,
        Iterable as Iterable,
        Iterator as Iterator,
        Mapping as Mapping,
        Sequence as Sequence,
    )
    from _functools import _lru_cache_wrapper
    from _operator import itemgetter

    class Any:
        """Any value."""

    # Used in annotations only, which are not read at run time.
    ClassVar = Final = Literal = Self = TypeAlias = TypeGuard = Any

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

    class _EnumerationMaker(type):
        """Metaclass of enumerations, whose members are instances of the class, one per value."""

        def __new__(cls, name: str, bases: tuple[type, ...], body: dict[str, object]) -> type:
            values = {} if bases[0] in (int, str) else body
            values = {key: value for key, value in values.items() if key.isupper()}
            made = super().__new__(cls, name, bases, body)
            made._by_value = {}
            for key, value in values.items():
                member = made._by_value[value] = made.__new__(made, value)
                member.name, member.value = key, value
                setattr(made, key, member)
            return made

        def __call__(cls, value: object) -> object:
            """Return the member with a value; ValueError if there is none."""
            if value not in cls._by_value:
                raise ValueError(f"{value!r} is not a valid {cls.__name__}")
            return cls._by_value[value]

        def __iter__(cls) -> object:
            return iter(cls._by_value.values())

    def _repr(member: object) -> str:
        return f"<{type(member).__name__}.{member.name}: {member.value!r}>"

    def _reduce(member: object, _protocol: int) -> tuple[type, tuple[object]]:
        return type(member), (member.value,)

    class IntEnum(int, metaclass=_EnumerationMaker):
        """Enumeration of integers; the names of its members are in capitals."""

        __str__ = int.__repr__
        __repr__, __reduce_ex__ = _repr, _reduce

    class StrEnum(str, metaclass=_EnumerationMaker):
        """Enumeration of texts; the names of its members are in capitals."""

        __repr__, __reduce_ex__ = _repr, _reduce

    def _named_after(function: object, copy: object) -> object:
        for name in ("__module__", "__name__", "__qualname__", "__doc__"):
            setattr(copy, name, getattr(function, name))
        copy.__wrapped__ = function
        return copy

    def cache(function: object) -> object:
        """Return a function that calls another one once for each tuple of arguments."""
        return _named_after(function, _lru_cache_wrapper(function, None, False, tuple))

    class _BlockOfGenerator:
        """Context manager of a generator, whose code behind ``yield`` ends a ``with`` block."""

        def __init__(self, generator: object) -> None:
            self._generator = generator

        def __enter__(self) -> object:
            return next(self._generator)

        def __exit__(self, _kind: object, error: object, traceback: object) -> bool:
            if error is None:
                for _ in self._generator:
                    raise RuntimeError("generator didn't stop")
                return False
            try:
                self._generator.throw(error)
            except StopIteration as end:
                return end is not error
            except BaseException as raised:
                if raised is not error:
                    raise
                error.__traceback__ = traceback
                return False
            raise RuntimeError("generator didn't stop after throw()")

    class suppress:  # noqa: N801 -- the name in contextlib
        """Context manager that ends a ``with`` block at exceptions of some kinds without them."""

        def __init__(self, *kinds: type[BaseException]) -> None:
            self._kinds = kinds

        def __enter__(self) -> None:
            pass

        def __exit__(self, kind: type[BaseException] | None, *_: object) -> bool:
            return kind is not None and issubclass(kind, self._kinds)

    def contextmanager(function: object) -> object:
        """Return a function whose call gives the context manager of a generator function."""

        def enter(*arguments: object, **named: object) -> _BlockOfGenerator:
            return _BlockOfGenerator(function(*arguments, **named))

        return _named_after(function, enter)

    def cast(_type: object, value: object) -> object:
        """Return the value unchanged; type checkers treat it as being of the type."""
        return value

    def overload(function: object) -> object:
        """Return the function unchanged; type checkers read its signature."""
        return function
