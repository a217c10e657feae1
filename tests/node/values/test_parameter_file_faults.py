"""A parameter file that is none: what is wrong with it is told, with its place."""

import pytest

from teleopctl.errors import InvalidFileError
from teleopctl.node import read_parameter_file, read_parameter_lines

SECTION = b"/talker:\n  ros__parameters:\n    fine: [1, 2.5]\n"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff\xfe\x00", ": it is not UTF-8 text"),
        (b"/**:\n  ros__parameters: [", ":3: not YAML: "),
        (SECTION + b'    x: !!int ""', ":4: not YAML: '' is no !!int"),
        (SECTION + b'    x: !!float ""', ":4: not YAML: '' is no !!float"),
        (SECTION + b"    x: !!bool maybe", ":4: not YAML: 'maybe' is no !!bool"),
        (SECTION + b"    x: !!timestamp x", ":4: not YAML: 'x' is no !!timestamp"),
        (
            SECTION + b"    a: {x: !!timestamp 2020-01-31}",
            ":4: parameter 'a.x' cannot be 2020-01-31",
        ),
        (SECTION + b"    x: !!set {a, b}", ":4: parameter 'x' cannot be {"),
        (SECTION + b"    x: [[1, 2]]", ":4: parameter 'x' cannot be [[1, 2]]: "),
        (SECTION + b"    x:\n    - a: [1, b]", ":5: parameter 'x.a' cannot be [1, 'b']: "),
        (SECTION + b"    x: [1, a]", ":4: parameter 'x' cannot be [1, 'a']: "),
        (
            SECTION + b"    x: 9223372036854775808",
            ":4: parameter 'x' cannot be 9223372036854775808",
        ),
        (b"- 1", ": a mapping of node names is expected at the top"),
    ],
)
def test_what_is_no_parameter_file_is_told_with_its_place(tmp_path, content, said):
    file = tmp_path / "parameters.yaml"
    file.write_bytes(content)
    with pytest.raises(InvalidFileError) as error:
        read_parameter_file(file)
    assert f"{file}{said}" in error.value.message


GPIOS = """gpio_controller:
  ros__parameters:
    command_interfaces:
      flange:
        - interfaces:
          - output1
        - more: 1
    empty: []
"""


def test_a_list_of_mappings_counts_as_one_mapping_as_in_ros_2(tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text(GPIOS, encoding="utf-8")
    names = ("command_interfaces.flange.interfaces", "command_interfaces.flange.more", "empty")
    values = read_parameter_file(file).for_node("/gpio_controller")
    assert values == dict(zip(names, (["output1"], 1, []), strict=True))
    lines = read_parameter_lines(file).for_node("/gpio_controller")
    assert lines == dict(zip(names, (5, 7, 8), strict=True))


def test_for_a_component_a_file_may_be_plain_and_its_name_wins_over_wildcards(tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text("speed: 1\ngroup: {rate: 2}\n", encoding="utf-8")
    values = read_parameter_file(file, may_be_plain=True).for_node("/any")
    assert values == {"speed": 1, "group.rate": 2}
    file.write_text("a: {ros__parameters: {x: 1}}\n/**: {ros__parameters: {x: 2, y: 2}}\n")
    read = read_parameter_file(file, may_be_plain=True)
    assert read.for_node("/a", names_win=True) == {"x": 1, "y": 2}
    assert read.for_node("/a") == {"x": 2, "y": 2}
