"""What lerobot's robot reads from the graph; lerobot itself is in tests.lerobot_programs."""

from __future__ import annotations

import threading

import pytest

from teleopctl.errors import NotFoundError, UnavailableError
from teleopctl.interfaces import get_message
from teleopctl.lerobot import newest
from teleopctl.lerobot.hand import HandProcess, reference_topics
from teleopctl.lerobot.newest import NewestImages, NewestPositions
from teleopctl.testing import eventually

JointState = get_message("sensor_msgs/msg/JointState")
Reference = get_message("control_msgs/msg/JointTrajectoryControllerState")
Image = get_message("sensor_msgs/msg/Image")


@pytest.fixture
def published(shared_ros):
    """Function that publishes a message on a topic 50 times a second."""
    ended, threads = threading.Event(), []

    def publish(topic, message) -> None:
        publisher = shared_ros.node.create_publisher(type(message), topic, 1)

        def run() -> None:
            while not ended.wait(0.02):
                publisher.publish(message)
            shared_ros.node.destroy_publisher(publisher)

        threads.append(threading.Thread(target=run))
        threads[-1].start()

    yield publish
    ended.set()
    for thread in threads:
        thread.join()


def test_positions_are_joint_states_or_the_references_of_a_controller(shared_ros, published):
    published("/states", JointState(name=["a", "b"], position=[1.0, 2.0]))
    reference = Reference(joint_names=["c"])
    reference.reference.positions = [3.0]
    published("/arm/controller_state", reference)
    assert NewestPositions(shared_ros.node, "states").read() == {"a": 1.0, "b": 2.0}
    assert NewestPositions(shared_ros.node, "/arm/controller_state").read() == {"c": 3.0}


def test_a_topic_of_another_type_or_without_a_publisher_is_named(
    shared_ros, published, monkeypatch
):
    published("/picture", Image(encoding="rgb8", width=2, height=1, step=6, data=bytes(6)))
    with pytest.raises(NotFoundError, match="/picture has sensor_msgs/msg/Image, not"):
        NewestPositions(shared_ros.node, "/picture")
    monkeypatch.setattr(newest, "FIRST_S", 0.1)
    with pytest.raises(UnavailableError, match="No node publishes /pictures"):
        NewestPositions(shared_ros.node, "/pictures")


def test_cameras_are_found_with_their_sizes_and_depths_left_out(shared_ros, published, monkeypatch):
    published("/front/image_raw", Image(encoding="bgr8", width=2, height=1, step=6, data=bytes(6)))
    published("/depth/image_raw", Image(encoding="16UC1", width=2, height=1, step=4, data=bytes(4)))
    monkeypatch.setattr(newest, "FIRST_S", 1.0)
    shared_ros.wait_for_message(Image, "/front/image_raw")
    shared_ros.wait_for_message(Image, "/depth/image_raw")
    found = NewestImages(shared_ros.node, {})
    assert found.sizes == {"front": (1, 2)}
    assert found.read()["front"].shape == (1, 2, 3)


def test_the_references_of_all_controllers_are_found(shared_ros, published):
    reference = Reference(joint_names=["c"])
    published("/hand/controller_state", reference)
    shared_ros.wait_for_message(Reference, "/hand/controller_state")
    assert "/hand/controller_state" in reference_topics(shared_ros.node)


def test_a_device_that_cannot_be_used_ends_with_its_sentence(shared_ros, capfd, monkeypatch):
    for name, value in shared_ros.env.items():
        monkeypatch.setenv(name, value)
    hand = HandProcess("no_such_device")
    with pytest.raises(UnavailableError, match="The device has ended with status 1"):
        eventually(lambda: hand.check())
    assert "There is no teleop device 'no_such_device'" in capfd.readouterr().err
    hand.stop()
