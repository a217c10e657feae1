"""A parameter file that is none: what is wrong with it is told, with its place."""

import pytest

from teleopctl.errors import InvalidFileError
from teleopctl.node import read_parameter_file


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff\xfe\x00", ": it is not UTF-8 text"),
        (b"/**:\n  ros__parameters: [", ":3: not YAML: "),
        (b"- 1", ": a mapping of node names is expected at the top"),
    ],
)
def test_what_is_no_parameter_file_is_told_with_its_place(tmp_path, content, said):
    file = tmp_path / "parameters.yaml"
    file.write_bytes(content)
    with pytest.raises(InvalidFileError) as error:
        read_parameter_file(file)
    assert f"{file}{said}" in error.value.message
