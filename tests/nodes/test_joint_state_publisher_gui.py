"""The sliders of a launch are on the page of the viewer that the launch has started."""

import os

import psutil
import pytest

from teleopctl.nodes import joint_state_publisher_gui as gui


class Sibling:
    """A process with a command line; one that has ended in the meantime without."""

    def __init__(self, line: str) -> None:
        self._words = line.split()

    def cmdline(self) -> list[str]:
        if not self._words:
            raise psutil.NoSuchProcess(1)
        return self._words


@pytest.mark.parametrize(
    ("siblings", "found"),
    [
        (["", "python -P -m teleopctl.nodes --builtin rviz2 rviz2 -r __node:=view"], "rviz2"),
        (["python -P -m teleopctl.nodes mujoco_sim mujoco_sim", "less rviz2"], None),
        ([], None),
    ],
)
def test_a_viewer_of_the_same_launch_is_known_by_its_program(monkeypatch, siblings, found):
    class Launch:
        def __init__(self, pid: int) -> None:
            assert pid == os.getppid()

        def children(self) -> list[Sibling]:
            return [Sibling(line) for line in siblings]

    monkeypatch.setattr(psutil, "Process", Launch)
    assert gui._viewer_of_this_launch() == found
