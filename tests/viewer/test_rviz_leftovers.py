"""What of an ``.rviz`` file is not shown, in one line."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from teleopctl.viewer.rviz_file import RvizFile
from teleopctl.viewer.scene_view import SceneView
from tests.viewer.conftest import FakePage
from tests.viewer.test_rviz_file import anything

AS_RVIZ_WRITES_IT = """\
Panels:
  - Class: rviz_common/Displays
    Property Tree Widget: {Expanded: ~, Splitter Ratio: 0.5}
  - {Class: rviz_common/Tool Properties, Name: Tool Properties}
Visualization Manager:
  Displays:
    - Alpha: 0.5
      Cell Size: 1
      Class: rviz_default_plugins/Grid
      Enabled: true
      Line Style: {Line Width: 0.029999999329447746, Value: Lines}
      Name: Grid
      Normal Cell Count: 0
      Offset: {X: 0, Y: 0, Z: 0}
      Value: true
    - Class: rviz_default_plugins/RobotModel
      Links: {All Links Enabled: true, base: {Alpha: 1, Show Axes: false, Value: true}}
      Mass Properties: {Inertia: false, Mass: false}
      Name: RobotModel
      Update Interval: 0
    - Class: rviz_default_plugins/TF
      Filter (blacklist): ""
      Frames: {All Enabled: true, base: {Value: true}}
      Name: TF
      Show Arrows: true
      Tree: {base: {tool: {}}}
    - Class: moveit_rviz_plugin/MotionPlanning
      MoveIt_Planning_Time: 5
      Name: MotionPlanning
      Planned Path: {Loop Animation: true, Show Robot Collision: false, Use Sim Time: false}
      Planning Request: {Planning Group: arm, Query Start State: false}
      Robot Description: robot_description
  Tools:
    - {Class: rviz_default_plugins/Measure, Line color: 128; 128; 0}
    - {Class: rviz_default_plugins/SetGoal, Topic: {Value: /goal_pose}}
  Views:
    Current: {Class: rviz_default_plugins/Orbit, Target Frame: <Fixed Frame>}
"""

Told = Any


@pytest.fixture
def told(stage: FakePage, tmp_path: Path) -> Told:
    """Opens a file, and gives the lines of the log."""

    def open_file(text: str) -> list[str]:
        path = tmp_path / "view.rviz"
        path.write_text(text)
        stage.node.warnings.clear()
        stage.displays = SceneView(stage.server, stage, path).displays
        return list(stage.node.warnings)

    return open_file


def test_of_a_file_in_which_nothing_is_set_nothing_is_told(told: Told) -> None:
    assert told(AS_RVIZ_WRITES_IT) == []


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("Offset: {X: 0", "Offset: {X: 2", "Offset of 'Grid' (line 14)"),
        ("Value: Lines}", "Value: Billboards}", "Line Style of 'Grid' (line 11)"),
        ("Mass: false", "Mass: true", "Mass Properties of 'RobotModel' (line 18)"),
        (
            "Query Start State: false",
            "Query Start State: true",
            "Planning Request/Query Start State of 'MotionPlanning' (line 31)",
        ),
        ("default_plugins/TF", "plugins/TF2", "displays of class TF2 (line 21)"),
        (
            "rviz_common/Tool Properties",
            "nav2_rviz_plugins/Navigation 2",
            "panel nav2_rviz_plugins/Navigation 2",
        ),
        (
            "rviz_default_plugins/Measure",
            "nav2_rviz_plugins/GoalTool",
            "tool nav2_rviz_plugins/GoalTool",
        ),
        (
            "rviz_default_plugins/Orbit",
            "rviz_default_plugins/FrameAligned",
            "view controller rviz_default_plugins/FrameAligned",
        ),
        ("Frame: <Fixed Frame>", "Frame: base", "target frame 'base' of the view"),
    ],
)
def test_what_somebody_has_set_and_is_not_shown_is_told_with_its_line(
    told: Told, tmp_path: Path, old: str, new: str, line: str
) -> None:
    assert AS_RVIZ_WRITES_IT.count(old) == 1
    assert told(AS_RVIZ_WRITES_IT.replace(old, new)) == [
        f"{tmp_path}/view.rviz: not shown, and kept when it is saved: {line}"
    ]


def test_however_much_there_is_to_tell_it_is_one_line(told: Told) -> None:
    grids = [
        f"    - {{Class: rviz/Grid, Name: 'g\\u001b{number}', Offset: {{X: 1}}, Odd: 1}}\n"
        for number in range(40)
    ]
    head, middle, tail = AS_RVIZ_WRITES_IT.partition("  Tools:\n")
    (line,) = told("".join((head, *grids, middle, tail)))
    assert "Offset, Odd of" in line
    assert line.endswith("; and 28 more")
    assert line.isprintable()


def test_what_is_told_is_still_written(told: Told, stage: FakePage) -> None:
    told(AS_RVIZ_WRITES_IT.replace("Offset: {X: 0", "Offset: {X: 2"))
    assert stage.displays[0].values.given["Offset"] == {"X": 2, "Y": 0, "Z": 0}


def test_a_robot_of_a_file_of_ros_1_is_described_by_the_topic_of_the_parameters_name(
    told: Told, stage: FakePage
) -> None:
    told("Visualization Manager: {Displays: [{Class: rviz/RobotModel, Robot Description: arm/it}]}")
    (display,) = stage.displays
    assert display.topic == "arm/it"


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(anything)
def test_no_document_is_too_strange(told: Told, stage: FakePage, document: Any) -> None:
    stage.displays = []
    text = RvizFile({"Visualization Manager": {"Displays": [document], "Tools": document}}).text()
    assert len(told(text)) <= 1
