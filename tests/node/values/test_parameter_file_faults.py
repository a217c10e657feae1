"""A parameter file that is none: what is wrong with it is told, with its place."""

import pytest

from teleopctl.errors import InvalidFileError
from teleopctl.node import read_parameter_file

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
