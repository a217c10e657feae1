"""A controller manager that does not answer, and one that takes its time."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from functools import partial
from typing import Any

import pytest

from teleopctl.control import client as control_client
from teleopctl.control.client import ControllerManagerClient, ControllerManagerUnavailableError
from teleopctl.interfaces import get_service
from teleopctl.node import Client, Context, Node, SingleThreadedExecutor
from teleopctl.testing import eventually
from tests.samples import sample

LIST = get_service("controller_manager_msgs/srv/ListControllers")
SWITCH = get_service("controller_manager_msgs/srv/SwitchController")

MANAGER = """
import rclpy
from controller_manager_msgs.srv import ListControllers, SwitchController

rclpy.init()
node = rclpy.create_node("controller_manager")
for name, type_ in ("list_controllers", ListControllers), ("switch_controller", SwitchController):
    node.create_service(type_, f"~/{name}", lambda request, response: response)
print("ready", flush=True)
rclpy.spin(node)
"""


@pytest.fixture
def stopped_manager(ros, tmp_path):
    path = tmp_path / "manager.py"
    path.write_text(MANAGER)
    manager = ros.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    manager.wait_for_line("ready")
    # It is stopped when the graph knows of its services.
    for service in ("list_controllers", "switch_controller"):
        eventually(partial(ros.node.count_services, f"/controller_manager/{service}"))
    os.kill(manager.pid, signal.SIGSTOP)
    yield
    os.kill(manager.pid, signal.SIGCONT)


@pytest.mark.skipif(sys.platform == "win32", reason="SIGSTOP is for POSIX only")
@pytest.mark.parametrize(
    ("words", "service"),
    sample(
        [
            ("control list_controllers", "list_controllers"),
            ("control switch_controllers --activate arm_controller", "switch_controller"),
        ],
        2,
    ),
)
def test_a_manager_that_is_stopped_is_named_within_seconds(ros, stopped_manager, words, service):
    began = time.monotonic()
    done = ros.run(words)
    # Five, and what a command takes to start and to end on a busy machine; it used to be thirty.
    assert time.monotonic() - began < 20
    assert (done.returncode, done.stdout) == (1, "")
    line, hint = done.stderr.splitlines()
    assert line.startswith(f"teleopctl: /controller_manager does not answer {service}")
    assert "kill -CONT" in hint


def test_a_manager_that_takes_its_time_is_waited_for(ros, monkeypatch):
    """As one does that activates hardware: its process answers Zenoh meanwhile."""
    del ros
    monkeypatch.setattr(control_client, "_NOT_FROZEN_S", 0.05)
    asked = threading.Event()
    is_server_frozen = Client.is_server_frozen
    answers: list[bool] = []

    def looked_at(client: Client[Any, Any]) -> bool:
        answers.append(is_server_frozen(client))
        asked.set()
        return answers[-1]

    monkeypatch.setattr(Client, "is_server_frozen", looked_at)

    def switch(_, response):
        asked.wait(30)
        response.ok = True
        return response

    with Context() as server_context, Context() as context:
        server, node = (
            Node(name, context=each, start_parameter_services=False)
            for name, each in (("controller_manager", server_context), ("asking", context))
        )
        server.create_service(LIST, "~/list_controllers", lambda _, response: response)
        server.create_service(SWITCH, "~/switch_controller", switch)
        executor = SingleThreadedExecutor(context=server_context)
        executor.add_node(server)
        threading.Thread(target=executor.spin, daemon=True).start()
        client = ControllerManagerClient(node, "/controller_manager")
        client.wait(30)
        assert client.switch_controllers(["arm_controller"])[0]
    assert answers == [False]


def test_a_manager_that_only_hangs_is_given_its_time(ros):
    """Its call may be one that takes long; what says so is the time-out of the call."""
    del ros
    with Context() as context:
        node = Node("controller_manager", context=context, start_parameter_services=False)
        node.create_service(LIST, "~/list_controllers", lambda _, response: response)
        client = ControllerManagerClient(node, "/controller_manager", call_timeout=0.1, attempts=1)
        client.wait(30)
        with pytest.raises(ControllerManagerUnavailableError, match="after 1 attempts"):
            client.list_controllers()
