"""The recorder of episodes refuses a robot and cameras that do not fit its data set."""

from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.bag import EpisodeSettings
from teleopctl.errors import RefusedError, UnavailableError
from teleopctl.interfaces import get_message
from teleopctl.nodes.episodes.fitting import EpisodeFitting

Image, JointState = get_message("sensor_msgs/msg/Image"), get_message("sensor_msgs/msg/JointState")
FEATURES = {
    "observation.state": {"names": ["joint_1.pos", "joint_2.pos"]},
    "observation.images.wrist": {"shape": [2, 4, 3]},
}
IMAGES = ["sensor_msgs/msg/Image"]


def fitting(message: Any, *cameras: str) -> EpisodeFitting:
    """Return what compares a graph with a data set; each topic has the same message."""
    topics = [("/joint_states", ["sensor_msgs/msg/JointState"]), *((c, IMAGES) for c in cameras)]
    node: Any = SimpleNamespace(
        context=SimpleNamespace(wait_for_change=lambda *_: None),
        get_topic_names_and_types=lambda: topics,
        count_publishers=lambda _: 1,
        get_logger=lambda: SimpleNamespace(warning=lambda _: None),
    )
    simulation: Any = SimpleNamespace(next_message=lambda *_: message)
    return EpisodeFitting(node, simulation, FEATURES, prefers_raw=False)


def image(width: int, height: int) -> Any:
    size = {"width": width, "height": height, "step": 3 * width}
    return Image(encoding="rgb8", data=bytes(3 * width * height), **size)


def test_pictures_of_another_size_are_refused_before_an_episode():
    topics = "/wrist/image_raw", "/new/image_raw"
    # One that the data set lacks is left out, and one of an odd size has a video of an even one.
    for height in (2, 1):
        assert fitting(image(4, height), *topics).cameras(()) == {"wrist": topics[0]}
    with pytest.raises(RefusedError, match="pictures of 4 x 2 from wrist, and the camera has 2 x"):
        fitting(image(2, 4), topics[0]).cameras(())


@pytest.mark.parametrize(
    ("texts", "kind", "problem"),
    [
        (["wrist=/a", "front=/b"], RefusedError, "has no pictures of front .it has wrist"),
        (["front=/b"], UnavailableError, "has pictures of wrist, and no such camera publishes"),
    ],
)
def test_cameras_that_are_not_those_of_the_data_set_are_refused(texts, kind, problem):
    with pytest.raises(kind, match=problem):
        fitting(image(4, 2), "/a", "/b").cameras(tuple(texts))


def test_a_camera_without_a_picture_is_named():
    with pytest.raises(UnavailableError, match="No image has come on /a for 10 s"):
        fitting(None, "/a").cameras(("wrist=/a",))


def test_a_camera_that_has_ended_since_the_last_episode_is_waited_for():
    with_cameras = EpisodeSettings(cameras=("wrist=/a", "/b"))
    assert fitting(None, "/a", "/b").is_published(with_cameras)
    assert not fitting(None, "/a").is_published(with_cameras)
    assert fitting(None).is_published(EpisodeSettings(state="/joint_states/position"))


def test_a_robot_without_a_joint_of_the_data_set_is_refused():
    fitting(JointState(name=["joint_2", "joint_1", "gripper"])).check_state("/joint_states")
    with pytest.raises(RefusedError, match="has the joint joint_2, and /joint_states has only joi"):
        fitting(JointState(name=["joint_1"])).check_state("/joint_states")
    with pytest.raises(UnavailableError, match="Nothing publishes /states, the state of the rob"):
        fitting(None).check_state("/states")
