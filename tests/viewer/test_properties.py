"""Properties of displays: what an ``.rviz`` file says, and what a user sets."""

import yaml
from hypothesis import HealthCheck, given, settings, strategies

from teleopctl.viewer.displays.properties import Properties, Property, Value

KNOWN = (
    Property("Alpha", 1.0, low=0.0, high=1.0),
    Property("Color", (25, 255, 0)),
    Property("Plane", "XY", choices=("XY", "XZ")),
    Property("Plane Cell Count", 10, low=1),
    Property("Show Axes", True),
    Property("Line Style/Line Width", 0.03),
    Property("Line Style", "Lines", choices=("Lines", "Billboards")),
)

FILE = """
Alpha: 0.5
Color: 204; 51; 51
Line Style:
  Line Width: 0.029999999329447746
  Value: Billboards
Plane Cell Count: 4
Show Axes: false
Unknown Thing: {Deep: 1}
"""

anything = strategies.recursive(
    strategies.none()
    | strategies.booleans()
    | strategies.integers()
    | strategies.floats()
    | strategies.text(),
    lambda inner: strategies.lists(inner) | strategies.dictionaries(strategies.text(), inner),
    max_leaves=8,
)


def test_a_file_is_read_as_rviz_writes_it():
    values = Properties(KNOWN, yaml.safe_load(FILE))
    assert values.number("Alpha") == 0.5
    assert values.color("Color") == (204, 51, 51)
    assert values.text("Line Style") == "Billboards"
    assert round(values.number("Line Style/Line Width"), 3) == 0.03
    assert values["Plane Cell Count"] == 4
    assert not values.flag("Show Axes")
    assert values.text("Plane") == "XY"


def test_what_is_set_is_what_is_read_and_the_rest_stays():
    given = yaml.safe_load(FILE)
    values = Properties(KNOWN, given)
    wanted: dict[str, Value] = {
        "Alpha": 0.25,
        "Color": (1, 2, 3),
        "Line Style": "Lines",
        "Line Style/Line Width": 0.5,
        "Plane": "XZ",
    }
    for name, value in wanted.items():
        values.set(name, value)
        assert values[name] == value
    assert given["Color"] == "1; 2; 3"
    assert given["Line Style"] == {"Line Width": 0.5, "Value": "Lines"}
    assert given["Unknown Thing"] == {"Deep": 1}


def test_a_number_keeps_to_its_range():
    assert Properties(KNOWN, {"Alpha": 7}).number("Alpha") == 1.0
    assert Properties(KNOWN, {"Plane Cell Count": -7})["Plane Cell Count"] == 1


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(strategies.dictionaries(strategies.sampled_from([p.name for p in KNOWN]), anything))
def test_whatever_a_file_says_a_property_has_its_type(given):
    values = Properties(KNOWN, given)
    for known in KNOWN:
        assert type(values[known.name]) is type(known.default)
