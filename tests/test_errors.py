"""The tree of errors is what its drawing says, and the exit status follows from the class."""

import re

import pytest

from teleopctl import commander, control, errors, kinematics, node, tf, wire
from teleopctl.errors import NotFoundError, TeleopctlError, UsageError

LINE = re.compile(r"^((?:│   )*)[├└]── (\w+)", re.MULTILINE)


def drawn() -> dict[str, str]:
    """Each class of the drawing with the class that it hangs from."""
    parents, above = {}, ["TeleopctlError"]
    for indent, name in LINE.findall(str(errors.__doc__)):
        depth = len(indent) // 4 + 1
        above[depth:] = [name]
        parents[name] = above[depth - 1]
    return parents


def class_named(name: str) -> type[TeleopctlError]:
    for place in (errors, commander, control, kinematics, node, tf, wire):
        if hasattr(place, name):
            found: type[TeleopctlError] = getattr(place, name)
            return found
    raise AssertionError(f"there is no class {name}")


@pytest.mark.parametrize(("name", "parent"), drawn().items())
def test_each_class_hangs_where_it_is_drawn(name, parent):
    assert class_named(name).__bases__ == (class_named(parent),)


def test_each_class_of_the_module_is_drawn():
    defined = {
        name
        for name, value in vars(errors).items()
        if isinstance(value, type) and issubclass(value, TeleopctlError)
    }
    assert defined - {"TeleopctlError"} <= set(drawn())


def test_only_what_was_asked_wrongly_ends_with_status_2():
    for name in drawn():
        found = class_named(name)
        assert found.exit_status == (2 if issubclass(found, UsageError) else 1)


def test_an_error_can_be_told_its_place_and_stays_what_it_is():
    located = NotFoundError("there is no such arm", hint="buy one").at("arm.yaml:3")
    assert isinstance(located, NotFoundError)
    assert (located.message, located.hint) == ("arm.yaml:3: there is no such arm", "buy one")
    assert located.place == "arm.yaml:3"


def test_names_that_are_spelt_alike_are_suggested_the_nearest_first():
    known = ["list", "info", "lists", "echo"]
    assert errors.similar_names("lsit", known) == ["list", "lists"]
    assert errors.similar_names("lsit", known, most=1) == ["list"]
    assert errors.did_you_mean("lsit", known) == "Did you mean list or lists?"
    assert errors.did_you_mean("xyz", known) is None
    assert errors.similarity("", "") == errors.similarity("a", "b") == 0.0
    assert errors.similarity("topic", "topic") == 1.0
    assert errors.similarity("topc", "topic") == pytest.approx(8 / 9)
