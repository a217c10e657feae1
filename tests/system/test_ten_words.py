"""The page of the ten words: its commands work, in their order."""

import shlex

from tests import ROOT
from tests.test_docs import command_lines

PAGE = ROOT / "docs" / "ten_words.md"


def test_the_commands_of_the_page_work_in_their_order(ros):
    said = {}
    for line in command_lines(PAGE):
        done = ros.run(shlex.split(line)[1:], 60, cwd=ROOT)
        assert (done.returncode, done.stderr) == (0, ""), f"{line}\n{done.stderr}"
        said[line.split()[1], line.split()[2]] = done.stdout
    assert "/mujoco_sim" in said["node", "list"]
    assert "arm_controller" in said["control", "list_controllers"]
    assert "1.0" in said["param", "get"]
    assert "1.0" in said["service", "call"]
    assert "Translation" in said["tf", "echo"]
    assert '<robot name="teleop"' in said["run", "xacro"]
