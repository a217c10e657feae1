"""The recorder of episodes refuses a robot and cameras that do not fit its data set."""

from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.errors import RefusedError
from teleopctl.interfaces import get_message
from teleopctl.nodes.episodes.recorder import EpisodeRecorder

Image, JointState = get_message("sensor_msgs/msg/Image"), get_message("sensor_msgs/msg/JointState")
FEATURES = {
    "observation.state": {"names": ["joint_1.pos", "joint_2.pos"]},
    "observation.images.wrist": {"shape": [2, 4, 3]},
}


def recorder(joints: list[str]) -> Any:
    """Return the part of a recorder that is asked, for a robot with joints."""
    return SimpleNamespace(
        _folder=SimpleNamespace(dataset=SimpleNamespace(features=FEATURES)),
        _simulation=SimpleNamespace(next_message=lambda *_: JointState(name=joints)),
        get_parameter=lambda _: SimpleNamespace(value="/joint_states"),
    )


def test_pictures_of_another_size_are_refused_before_an_episode():
    fits = Image(encoding="rgb8", width=4, height=2, step=12, data=bytes(24))
    other = Image(encoding="rgb8", width=2, height=4, step=6, data=bytes(24))
    EpisodeRecorder._check_size(recorder([]), "wrist", fits)
    EpisodeRecorder._check_size(recorder([]), "new_camera", other)
    with pytest.raises(RefusedError, match="pictures of 4 x 2 from wrist, and the camera has 2 x"):
        EpisodeRecorder._check_size(recorder([]), "wrist", other)


def test_a_robot_without_a_joint_of_the_data_set_is_refused():
    EpisodeRecorder._check_joints(recorder(["joint_2", "joint_1", "gripper"]))
    with pytest.raises(RefusedError, match="has the joint joint_2, and /joint_states has only joi"):
        EpisodeRecorder._check_joints(recorder(["joint_1"]))
