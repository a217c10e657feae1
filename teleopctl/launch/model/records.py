"""Stand-in for ``dataclasses``, which takes a third of the time that a small launch takes to start.

`dataclasses.dataclass` compiles up to eight functions for each class. The methods here are the same
functions for all classes: half a microsecond slower per object, of which a launch has hundreds.
Type checkers see the real decorator, and classes made by the real one may derive from these.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import (
        asdict as asdict,
        dataclass as dataclass,
        field as field,
        replace as replace,
    )
else:

    class _Factory:
        """Default of a field that is made anew for each object."""

        __slots__ = ("make",)

        def __init__(self, make: object) -> None:
            self.make = make

    def field(*, default_factory: object) -> _Factory:
        """Return the default of a field that is made anew for each object."""
        return _Factory(default_factory)

    # Any: the class, or a decorator of classes.
    def dataclass(class_: type | None = None, **options: bool) -> Any:
        """Add the methods of a data class to a class: ``frozen`` and ``kw_only`` as in Python's."""
        if class_ is None:
            return lambda each: dataclass(each, **options)
        names, defaults = {}, {}
        for base in reversed(class_.__mro__):
            names |= dict.fromkeys(getattr(base, "__record_fields__", ()))
            defaults |= getattr(base, "__record_defaults__", {})
        for name, kind in vars(class_).get("__annotations__", {}).items():
            if not str(kind).startswith("ClassVar"):
                names[name] = None
                if name in class_.__dict__:
                    defaults[name] = class_.__dict__[name]
        class_.__record_fields__ = tuple(names)
        class_.__record_defaults__ = defaults
        class_.__match_args__ = () if options.get("kw_only") else tuple(names)
        for attribute in ("__dataclass_fields__", "__dataclass_params__"):
            setattr(class_, attribute, _OfPython(attribute, bool(options.get("frozen"))))
        methods = {"__init__": _initialize, "__repr__": _repr, "__eq__": _equal}
        methods["__hash__"] = _hash if options.get("frozen") else None
        if options.get("frozen"):
            methods |= {"__setattr__": _refuse, "__delattr__": _refuse}
        for name, method in methods.items():
            if name not in class_.__dict__ or (name == "__hash__" and method is None):
                setattr(class_, name, method)
        return class_

    class _OfPython:
        """Attribute of Python's data classes, for its own functions, made when these ask for it."""

        def __init__(self, attribute: str, frozen: bool) -> None:
            self._attribute = attribute
            self._frozen = frozen

        def __get__(self, _: object, owner: type) -> object:
            import dataclasses

            body = {
                name: dataclasses.field(default_factory=default.make)
                if isinstance(default, _Factory)
                else default
                for name, default in owner.__record_defaults__.items()
            }
            body["__annotations__"] = dict.fromkeys(owner.__record_fields__, "object")
            decorate = dataclasses.dataclass(kw_only=True, frozen=self._frozen)
            return getattr(decorate(type("Record", (), body)), self._attribute)

    def _initialize(self: object, *values: object, **named: object) -> None:
        class_ = type(self)
        names, defaults = class_.__record_fields__, class_.__record_defaults__
        if len(values) > len(class_.__match_args__):
            raise TypeError(f"{class_.__name__} takes {len(class_.__match_args__)} values in order")
        given = dict(zip(names, values, strict=False))
        if given.keys() & named or not named.keys() <= {*names}:
            raise TypeError(f"{class_.__name__} has the fields {', '.join(names)}, each once")
        given |= named
        put = object.__setattr__
        for name in names:
            if name in given:
                put(self, name, given[name])
            elif name in defaults:
                default = defaults[name]
                put(self, name, default.make() if isinstance(default, _Factory) else default)
            else:
                raise TypeError(f"{class_.__name__} needs a value for {name}")

    def _values(record: object) -> tuple[object, ...]:
        return tuple(getattr(record, name) for name in type(record).__record_fields__)

    def _equal(self: object, other: object) -> bool:
        return type(self) is type(other) and _values(self) == _values(other)

    def _hash(self: object) -> int:
        return hash(_values(self))

    def _repr(self: object) -> str:
        names = type(self).__record_fields__
        shown = (f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__qualname__}({', '.join(shown)})"

    def _refuse(self: object, name: str, *_: object) -> None:
        raise AttributeError(f"cannot change {name!r} of a {type(self).__name__}")

    def replace(record: object, **changes: object) -> object:
        """Return a copy of a record with some fields changed."""
        names = type(record).__record_fields__
        return type(record)(**{**dict(zip(names, _values(record), strict=True)), **changes})

    def asdict(record: object) -> dict[str, object]:
        """Return the fields of a record by name; their values are not converted."""
        return dict(zip(type(record).__record_fields__, _values(record), strict=True))
