"""Records of launches do what Python's data classes do, and Python's functions take them."""

from __future__ import annotations

import copy
import dataclasses
from typing import Any

import pytest

from teleopctl.launch.model import records


def made(decorate: Any, field: Any) -> tuple[type[Any], type[Any]]:
    """The same two classes, by one decorator."""

    @decorate(frozen=True, slots=True)
    class Place:
        x: float
        name: str = "here"

    @decorate(slots=True, kw_only=True)
    class Visit:
        place: Place
        notes: list[str] = field(default_factory=list)

    return Place, Visit


OURS = made(records.dataclass, records.field)
THEIRS = made(dataclasses.dataclass, dataclasses.field)


@pytest.mark.parametrize(("place", "visit"), [OURS, THEIRS])
def test_a_record_is_made_compared_printed_copied_and_kept_from_changes(place, visit):
    here = place(1.0)
    assert here == place(x=1.0, name="here") != place(2.0)
    assert {here: 5}[place(1.0)] == 5
    assert repr(here).endswith("Place(x=1.0, name='here')")
    assert copy.deepcopy(here) == here
    with pytest.raises(AttributeError):
        here.x = 2.0
    visits = [visit(place=here), visit(place=here, notes=["a"])]
    visits[0].notes.append("b")
    assert [each.notes for each in visits] == [["b"], ["a"]]
    for values, named in (((), {}), ((1.0, "a", 3), {}), ((1.0,), {"x": 2.0}), ((), {"y": 1.0})):
        with pytest.raises(TypeError):
            place(*values, **named)
    with pytest.raises(TypeError):
        visit(here)
    assert place.__match_args__ == ("x", "name")


def test_pythons_functions_on_data_classes_take_records():
    place, visit = OURS
    here = place(1.0)
    assert dataclasses.replace(here, x=2.0) == place(2.0) == records.replace(here, x=2.0)
    assert dataclasses.asdict(here) == records.asdict(here) == {"x": 1.0, "name": "here"}

    further = dataclasses.make_dataclass(
        "Further", [("z", float, 0.0)], bases=(place,), frozen=True
    )
    assert further(x=1.0, z=2.0).name == "here"
    assert dataclasses.is_dataclass(visit)
