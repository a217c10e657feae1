"""Other nodes that hold the robot stopped are asked to release it."""

import pytest

from teleopctl.interfaces import get_service
from teleopctl.nodes.teleop import stop_releaser
from teleopctl.nodes.teleop.stop_releaser import StopReleaser
from teleopctl.testing import eventually

Trigger = get_service("std_srvs/srv/Trigger")


def test_a_node_that_has_just_stopped_the_robot_is_asked_once_its_service_is_known(shared_ros):
    notes: list[str] = []
    asked: list[object] = []
    releaser = StopReleaser(shared_ros.node, notes.append)
    releaser.ask(["/panel"])

    def release(request, response):
        asked.append(request)
        return response

    service = shared_ros.node.create_service(Trigger, "/panel/release", release)

    def is_asked():
        releaser.ask_again()
        return asked

    eventually(is_asked)
    releaser.ask_again()
    shared_ros.node.destroy_service(service)
    assert (len(asked), notes) == (1, [])


def test_a_node_without_the_service_is_named(shared_ros, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(stop_releaser, "_FOUND_S", 0.05)
    notes: list[str] = []
    releaser = StopReleaser(shared_ros.node, notes.append)
    releaser.ask(["/panel"])
    assert notes == []

    def is_noted():
        releaser.ask_again()
        return notes

    eventually(is_noted)
    assert notes == ["The robot is stopped by /panel: release it there"]
