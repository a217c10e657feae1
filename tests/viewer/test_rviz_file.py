"""``.rviz`` files, as RViz writes them."""

import copy
import math
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings, strategies

from teleopctl.errors import TeleopctlError
from teleopctl.viewer.rviz_file import RvizFile, View

FILE = """
Panels:
  - Class: rviz_common/Displays
    Name: Displays
Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz_default_plugins/Grid
      Name: Ground
      Cell Size: 0.25
      Enabled: true
      Value: true
    - Class: rviz_common/Group
      Name: Sensors
      Enabled: false
      Displays:
        - Class: rviz/LaserScan
          Name: Front
          Enabled: true
          Topic: {Value: /scan, Reliability Policy: Best Effort}
        - Class: rviz_common/Group
          Enabled: true
          Displays:
            - {Class: rviz_default_plugins/PointCloud2, Enabled: true}
    - Class: somebody_rviz/Thing
      Name: Thing
      Odd: {Deep: [1, 2]}
  Enabled: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: /odom
    Frame Rate: 30
  Tools:
    - Class: rviz_default_plugins/MoveCamera
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Distance: 2
      Focal Point: {X: 1, Y: 2, Z: 0.5}
      Pitch: 0.5
      Yaw: 0
      Target Frame: <Fixed Frame>
Window Geometry:
  Height: 846
"""

anything = strategies.recursive(
    strategies.none()
    | strategies.booleans()
    | strategies.integers()
    | strategies.floats(allow_nan=False)
    | strategies.text(),
    lambda inner: (
        strategies.lists(inner)
        | strategies.dictionaries(
            strategies.sampled_from(
                ["Class", "Displays", "Views", "Current", "Enabled", "Global Options", "Name", "X"]
            )
            | strategies.text(),
            inner,
        )
    ),
)


@pytest.fixture
def file():
    return RvizFile(yaml.safe_load(FILE))


def test_displays_come_in_order_out_of_their_groups(file):
    found = [(e.rviz_class, e.name, e.in_shown_group) for e in file.displays()]
    assert found == [
        ("Grid", "Ground", True),
        ("LaserScan", "Front", False),
        ("PointCloud2", "PointCloud2", False),
        ("Thing", "Thing", True),
    ]


def test_what_is_not_understood_is_written_back_as_it_was(file):
    file.displays()
    assert yaml.safe_load(file.text()) == yaml.safe_load(FILE)


def test_a_display_that_is_added_or_removed_is_so_in_the_file(file):
    inside_a_group = file.displays()[1]
    file.remove(inside_a_group.given)
    given: dict[str, Any] = {"Topic": {"Value": "/path"}}
    file.add("Path", "My path", given)
    given["Alpha"] = 0.5
    again = RvizFile(yaml.safe_load(file.text())).displays()
    assert [entry.name for entry in again] == ["Ground", "PointCloud2", "Thing", "My path"]
    assert again[-1].given["Class"] == "rviz_default_plugins/Path"
    assert again[-1].given["Alpha"] == 0.5


def test_fixed_frame_background_and_view_are_read(file):
    assert file.fixed_frame == "odom"
    assert file.background == (48, 48, 48)
    view = file.view
    assert view is not None
    assert view.focus == (1, 2, 0.5)
    assert view.eye == pytest.approx((1 + 2 * math.cos(0.5), 2, 0.5 + 2 * math.sin(0.5)))


def test_a_top_view_looks_straight_down(file):
    file.document["Visualization Manager"]["Views"]["Current"] = {
        "Class": "rviz_default_plugins/TopDownOrtho",
        "Scale": 100,
        "X": 3,
        "Y": 4,
    }
    view = file.view
    assert view is not None
    assert view.focus == (3, 4, 0)
    assert view.eye[2] > 1
    assert view.eye[:2] == pytest.approx((3, 4), abs=0.02 * view.eye[2])


coordinates = strategies.floats(-100, 100)
points = strategies.tuples(coordinates, coordinates, coordinates)


@given(points, points)
def test_a_view_that_is_saved_is_the_view_that_is_read(eye, focus):
    steepness = abs(eye[2] - focus[2]) / (math.dist(eye, focus) or 1)
    if math.dist(eye, focus) < 1e-3 or steepness > 0.999:
        return
    file = RvizFile()
    file.view = View(eye, focus)
    view = RvizFile(yaml.safe_load(file.text())).view
    assert view is not None
    assert view.eye == pytest.approx(eye, abs=1e-5)
    assert view.focus == pytest.approx(focus)


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(anything)
def test_no_document_is_too_strange(document):
    file = RvizFile({"Visualization Manager": copy.deepcopy(document)})
    for entry in file.displays():
        assert isinstance(entry.name, str)
    assert file.view is None or all(math.isfinite(part) for part in file.view.eye)
    assert file.background is None or len(file.background) == 3
    assert isinstance(file.fixed_frame, str)
    file.text()


@pytest.mark.parametrize("text", ["", "[1, 2]", "a: [", "Visualization Manager: 3", "{}"])
def test_what_is_no_rviz_file_is_refused_by_its_name(tmp_path, text):
    path = tmp_path / "view.rviz"
    path.write_text(text)
    with pytest.raises(TeleopctlError, match=r"view\.rviz"):
        RvizFile.load(path)
    with pytest.raises(TeleopctlError, match=r"missing\.rviz"):
        RvizFile.load(tmp_path / "missing.rviz")


def test_what_ros_1_called_otherwise_is_known():
    displays = [{"Class": "rviz/WrenchStamped", "Name": "force"}]
    (entry,) = RvizFile({"Visualization Manager": {"Displays": displays}}).displays()
    assert (entry.rviz_class, entry.name) == ("Wrench", "force")
