"""The teleop arm takes a cube from a table into a bin; the recording is repeated to the bit."""

from __future__ import annotations

import pytest

from teleopctl.bag import open_bag
from teleopctl.nodes.bag_verification.verification import verify_bag
from tests.samples import is_nightly


@pytest.mark.nightly
def test_a_cube_is_taken_into_the_bin_and_is_so_again_to_the_bit(ros):
    # In a nightly run it is so again, by the same command and by its recording.
    for name in ("first", "second") if is_nightly() else ("first",):
        launch = ros.spawn(
            "launch pick_and_place.yaml camera:=false times:=1 seed:=7 real_time_factor:=0 "
            f"record:={name}"
        )
        launch.wait_for_line(r"1 of 1: the cube is in the bin")
        launch.wait_for_line(r"1 of 1 cubes are in the bin")
        launch.wait_for_line(r"pick_and_place-\d+\]: process has finished cleanly")
        launch.interrupt()
        launch.wait()
    first = determined_messages(ros.folder / "first")
    assert len(first) > 3000
    if is_nightly():
        assert determined_messages(ros.folder / "second") == first
        found = verify_bag(ros.folder / "first").verdict
        assert found.is_same, found.first_differences
        assert found.played_back["/mujoco_sim/changes"] > 100


def determined_messages(path):
    """The messages that a run determines; of those that are repeated while paused, one."""
    with open_bag(path) as bag:
        return list(
            dict.fromkeys(
                (topic, bytes(each.data)) for topic in DETERMINED for each in bag.messages([topic])
            )
        )


DETERMINED = (
    *("/clock", "/joint_states", "/robot_joint_states", "/robot_joint_commands"),
    *("/mujoco_sim/changes", "/mujoco_sim/free_joint_states", "/mujoco_sim/contacts"),
)


@pytest.mark.nightly
def test_another_robot_is_refused(ros):
    robot = ros.folder / "pole.urdf"
    robot.write_text('<robot name="pole"><link name="base"/></robot>')
    ros.launch("display.yaml", f"model:={robot}", "viewer:=false")
    done = ros.run("run pick_and_place")
    assert done.returncode == 1
    assert "The robot 'pole' is not the teleop arm" in done.stderr
