"""Episodes of a simulated arm: recorded by services and keys, repeated to the bit, never lost."""

from __future__ import annotations

import json
import threading

import pytest

from teleopctl.bag import EpisodeFolder, open_bag
from teleopctl.interfaces import get_message, get_service
from teleopctl.nodes.bag_verification.verification import verify_bag
from teleopctl.testing import LONGEST_WAIT_S, eventually

Trigger = get_service("std_srvs/srv/Trigger")
Image = get_message("sensor_msgs/msg/Image")
COMMAND = """{joint_names: [joint_1, joint_2, joint_3],
points: [{positions: [0.5, -0.4, 0.6], time_from_start: {nanosec: 300000000}}]}"""
WORLD = "package://teleopctl/worlds/pick_and_place.yaml"


@pytest.fixture
def camera(ros):
    """A camera of another robot, which publishes a small image 50 times a second."""
    publisher = ros.node.create_publisher(Image, "/front/image_raw", 1)
    image = Image(encoding="rgb8", width=8, height=8, step=24, data=bytes(192))
    ended = threading.Event()

    def publish() -> None:
        while not ended.wait(0.02):
            image.header.stamp = ros.node.get_clock().now().to_msg()
            publisher.publish(image)

    thread = threading.Thread(target=publish)
    thread.start()
    yield
    ended.set()
    thread.join()


def call(ros, name):
    client = ros.node.create_client(Trigger, f"/episode_recorder/{name}")
    assert client.wait_for_service(LONGEST_WAIT_S)
    response = client.call(Trigger.Request(), LONGEST_WAIT_S)
    ros.node.destroy_client(client)
    assert response is not None
    return response.success, response.message


def test_episodes_are_saved_repeated_and_outlive_a_killed_recorder(ros, camera):
    ros.launch("sim.yaml", "camera:=false", f"world:={WORLD}")
    settings = "-p folder:=cube -p task:=push -p reset:=true -p seed:=3"
    recorder = ros.spawn(f"run episode_recorder episode_recorder --ros-args {settings}")
    assert call(ros, "save") == (False, "No episode is being recorded: start one")
    places = []
    for number in range(2):
        assert call(ros, "start") == (True, f"Recording episode {number}")
        topic = "/arm_controller/joint_trajectory trajectory_msgs/msg/JointTrajectory"
        ros.run(["topic", "pub", "--once", *topic.split(), COMMAND])
        ros.wait_for_message(get_message("sensor_msgs/msg/JointState"), "/joint_states", moved)
        assert call(ros, "success") == (True, f"Episode {number} is a success")
        assert call(ros, "save") == (True, f"Saved episode {number}")
        with open_bag(ros.folder / f"cube/episodes/episode_{number:06d}.mcap") as bag:
            places.append(next(iter(bag.messages(["/mujoco_sim/free_joint_states"]))).data[-80:])
    # The cube lies elsewhere in each episode; one that began by a reset has the same bits again.
    assert places[0] != places[1]
    found = verify_bag(ros.folder / "cube/episodes/episode_000001.mcap").verdict
    assert found.is_same, found.first_differences
    assert found.played_back["/robot_joint_commands"] > 3

    assert call(ros, "start") == (True, "Recording episode 2")
    recorder.wait_for_line("Episode 1: ")  # both are in the data set
    (draft,) = (ros.folder / "cube/episodes/.recording").glob("*/*.mcap")
    eventually(lambda: draft.stat().st_size > 50_000, what="messages on the disk")
    recorder.kill()
    recorder.wait()
    folder = EpisodeFolder(ros.folder / "cube")
    assert [row.notes.success for row in folder.rows()] == [True, True]
    assert set(folder.dataset.features) >= {"observation.images.front", "action"}
    with open_bag(folder.unfinished()[0]) as bag:
        assert bag.metadata.message_count > 0

    listed = ros.run("episode list cube")
    assert listed.stdout.splitlines()[1].split()[-2:] == ["success", "push"]
    assert "An episode that was not saved is in cube/episodes/.recording" in listed.stderr
    described = json.loads(ros.run("episode stats cube --json").stdout)
    assert (described["episodes"], described["successes"]) == (2, 2)
    # Cut off, it has the state at its new start, from which it has the same bits.
    assert ros.run("episode trim cube 1 --start 0.2").returncode == 0
    found = verify_bag(ros.folder / "cube/episodes/episode_000001.mcap").verdict
    assert found.is_same, found.first_differences
    refused = ros.run("episode record cube --task push --fps 10")
    assert (refused.returncode, refused.stdout) == (1, "")
    assert "The data set in cube has 30 frames a second, not 10" in refused.stderr


def moved(state) -> bool:
    return bool(dict(zip(state.name, state.position, strict=True))["joint_1"] > 0.4)
