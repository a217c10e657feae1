"""What stands in for typing and its like when a program runs does what the real one does."""

from __future__ import annotations

import contextlib
import enum
import pickle
import typing

import pytest
from std_msgs.msg import String

from teleopctl.base import typed
from teleopctl.cli.verb import Option
from teleopctl.node import Publisher


class Ours(typed.NamedTuple):
    """A place."""

    x: float
    name: str = "here"

    @property
    def label(self) -> str:
        """What is written beside it."""
        return f"{self.name}: {self.x}"


class Theirs(typing.NamedTuple):
    """A place."""

    x: float
    name: str = "here"

    @property
    def label(self) -> str:
        """What is written beside it."""
        return f"{self.name}: {self.x}"


@pytest.mark.parametrize("of", ["_fields", "_field_defaults", "__doc__", "__match_args__"])
def test_a_named_tuple_has_the_fields_defaults_and_text_of_its_class_statement(of):
    assert getattr(Ours, of) == getattr(Theirs, of)


def test_a_named_tuple_behaves_as_one_of_typing():
    ours, theirs = Ours(1.0), Theirs(1.0)
    assert tuple(ours) == tuple(theirs)
    assert ours.label == theirs.label
    assert repr(ours) == repr(theirs).replace("Theirs", "Ours")
    assert ours._replace(name="there") == (1.0, "there")
    assert (Ours.__module__, Ours.__qualname__) == (__name__, "Ours")


@pytest.mark.parametrize("values", [(), (1.0, "here", "there")])
@pytest.mark.parametrize("named", [{}, {"x": 1.0}, {"y": 1.0}])
def test_a_named_tuple_refuses_the_values_that_one_of_typing_refuses(values, named):
    try:
        made = Theirs(*values, **named)
    except TypeError:
        with pytest.raises(TypeError, match="Ours has the fields x, name"):
            Ours(*values, **named)
    else:
        assert tuple(Ours(*values, **named)) == tuple(made)


def test_a_named_tuple_is_the_same_after_pickling():
    assert pickle.loads(pickle.dumps(Ours(1.0, "there"))) == Ours(1.0, "there")


def test_annotated_keeps_the_type_and_what_is_said_of_it():
    option = Option("--all", help="All.")
    for made in (typed.Annotated[bool, option], typing.Annotated[bool, option]):
        assert getattr(made, "__origin__") is bool  # noqa: B009 -- what verbs are read by
        assert getattr(made, "__metadata__") == (option,)  # noqa: B009


def test_a_class_that_leaves_types_open_is_given_them_and_may_be_derived_from():
    class StringPublisher(Publisher[String]):
        """Sends text."""

    assert StringPublisher.__mro__[1] is Publisher
    assert typing.get_args(Publisher[String]) == (String,)


class OurLevel(typed.IntEnum):
    """A level."""

    LOW = 1
    HIGH = 2


class TheirLevel(enum.IntEnum):
    """A level."""

    LOW = 1
    HIGH = 2


def test_an_enumeration_has_the_members_texts_and_refusals_of_one_of_enum():
    for ours, theirs in zip(OurLevel, TheirLevel, strict=True):
        assert (ours.name, ours.value, int(ours)) == (theirs.name, theirs.value, int(theirs))
        assert (str(ours), f"{ours:02d}") == (str(theirs), f"{theirs:02d}")
        assert repr(ours).replace("Our", "Their") == repr(theirs)
        assert pickle.loads(pickle.dumps(ours)) is ours is OurLevel(ours.value)
    with pytest.raises(ValueError, match="3 is not a valid OurLevel"):
        OurLevel(3)


def test_a_cached_function_is_called_once_for_its_arguments():
    calls = []

    @typed.cache
    def square(x: int) -> int:
        calls.append(x)
        return x * x

    assert [square(2), square(2), square(3)] == [4, 4, 9]
    assert calls == [2, 3]
    square.cache_clear()
    assert (square(2), calls) == (4, [2, 3, 2])


@pytest.mark.parametrize("manager", [typed.contextmanager, contextlib.contextmanager])
def test_a_generator_is_a_context_that_sees_and_may_swallow_an_error(manager):
    seen: list[object] = []

    @manager
    def block(swallows):
        seen.append("before")
        try:
            yield 5
        except ValueError as error:
            seen.append(str(error))
            if not swallows:
                raise
        seen.append("after")

    with block(True) as value:
        seen.append(value)
    with block(True):
        raise ValueError("a")
    with pytest.raises(ValueError, match="b"), block(False):
        raise ValueError("b")
    with pytest.raises(KeyError), block(True):
        raise KeyError
    assert seen == ["before", 5, "after", "before", "a", "after", "before", "b", "before"]
