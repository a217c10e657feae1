"""A component container as a process, and what loads components into it."""

import json
import re
import shlex
import socket
import sys
from pathlib import Path
from textwrap import dedent

import pytest

from teleopctl.cli import main
from teleopctl.cli.completion import completing
from teleopctl.testing import LONGEST_WAIT_S, eventually
from tests.distributions import install

BOX = "/ComponentManager"


@pytest.fixture(scope="module")
def container(shared_ros):
    """A container in a graph that this process is in, too."""
    running = shared_ros.spawn("run rclpy_components component_container")
    eventually(lambda: main.run(["component", "list", BOX]) == 0, what="the container")
    return running


@pytest.fixture
def component(container, capsys):
    """Runs ``component``; returns status, output and errors."""

    def run(line):
        capsys.readouterr()
        return (main.run(["component", *shlex.split(line)]), *capsys.readouterr())

    yield run
    for each in json.loads(run(f"list {BOX} --json")[1])[0]["components"]:
        run(f"unload {BOX} {each['id']}")


def test_components_are_loaded_listed_and_unloaded_in_the_words_of_ros2(component, shared_ros):
    status, out, _ = component(
        "load ComponentManager composition composition::Talker -n alice --node-namespace /left "
        "-r chatter:=said -p use_sim_time:=false -e use_intra_process_comms:=true --log-level warn"
    )
    assert status == 0
    loaded = re.fullmatch(
        f"Loaded component (\\d+) into '{BOX}' container node as '/left/alice'\n", out
    )
    assert loaded is not None
    first = int(loaded[1])
    assert (
        "Hello World" in shared_ros.run("topic echo --once /left/said std_msgs/msg/String").stdout
    )
    second = first + 1
    shown = component(f"load -q {BOX} composition composition::Listener")[1]
    assert shown == f"{second}  /listener\n"
    assert component("list") == (0, f"{BOX}\n  {first}  /left/alice\n  {second}  /listener\n", "")
    assert component(f"list {BOX} --no-daemon")[1] == (
        f"{first}  /left/alice\n{second}  /listener\n"
    )
    assert component("list --containers-only")[1] == f"{BOX}\n"
    assert json.loads(component("list --json")[1]) == [
        {
            "container": BOX,
            "components": [
                {"id": first, "node": "/left/alice"},
                {"id": second, "node": "/listener"},
            ],
        }
    ]
    shown = component(f"unload {BOX} {first}")[1]
    assert shown == f"Unloaded component {first} from '{BOX}' container node\n"
    assert component(f"unload -q {BOX} {second}")[1] == f"{second}\n"
    assert component(f"list {BOX}") == (0, "", "")


def test_what_cannot_be_done_says_why(component):
    status, out, err = component(f"load {BOX} composition composition::Talkr")
    assert (status, out) == (1, "")
    assert err.splitlines()[:2] == [
        "teleopctl: Failed to load component: Failed to find class with the requested plugin name.",
        "  Did you mean composition::Talker or composition::Client or composition::Server?",
    ]
    assert "Unable to find container node '/box'" in component("list box")[2]
    assert component(f"unload {BOX} 99")[2].startswith(
        f"teleopctl: Failed to unload component 99 from '{BOX}' container node\n"
        "    No node found with unique_id: 99\n"
    )
    assert component(f"unload {BOX} one")[0] == 2
    assert component(f"load {BOX} composition composition::Talker -r chatter")[0] == 2


def test_tab_completes_containers_packages_types_and_numbers(component):
    assert completing.candidates(["component", "load"], "/C") == [BOX]
    assert completing.candidates(["component", "load", BOX], "compo") == ["composition"]
    offered = completing.candidates(["component", "load", BOX, "composition"], "composition::L")
    assert offered == ["composition::Listener"]
    component(f"load {BOX} composition composition::Listener")
    (number,) = completing.candidates(["component", "unload", BOX], "") or []
    assert component(f"list {BOX}")[1] == f"{number}  /listener\n"


def test_a_component_runs_alone_until_ctrl_c(ros):
    alone = ros.spawn("component standalone composition composition::Talker -n solo -c single")
    alone.wait_for_line("Publishing: 'Hello World: 1'")
    assert ros.run("component list").stdout == "/single\n  1  /solo\n"
    alone.interrupt()
    assert alone.wait() == 0
    done = ros.run("component standalone composition composition::Talkr")
    assert done.returncode == 1
    # First what the container logs, with the time.
    assert done.stderr.splitlines()[1:] == [
        "teleopctl: Failed to load component: Failed to find class with the requested plugin name.",
        "  Did you mean composition::Talker or composition::Client or composition::Server?",
    ]


STRANGERS = """
    from rclpy.lifecycle import LifecycleNode
    from rclpy.node import Node


    class Eye(Node):
        def __init__(self):
            super().__init__("eye")
            raise OSError("no camera at /dev/video0")


    class Managed(LifecycleNode):
        def __init__(self):
            super().__init__("managed")
"""
LAUNCH = f"""
launch:
- lifecycle_node:
    exec: {sys.executable}
    args: -m teleopctl.nodes {Path(__file__).parents[1] / "compat/programs/lifecycle.py"}
    name: arm
    namespace: far
    autostart: true
- load_composable_node:
    target: /far/box
    composable_node:
    - {{pkg: strangers, plugin: "strangers::Eye", name: eye}}
    - {{pkg: composition, plugin: "composition::Listener", namespace: far}}
    composable_lifecycle_node:
    - {{pkg: strangers, plugin: "strangers::Managed", namespace: far, autostart: true}}
- node_container:
    {{pkg: rclcpp_components, exec: component_container_isolated, name: box, namespace: far}}
"""


def test_a_launch_loads_one_after_the_other_and_goes_on_without_what_fails(ros):
    site = ros.folder / "site"
    entries = {f"strangers::{name}": f"strangers_parts:{name}" for name in ("Eye", "Managed")}
    install(site, "strangers", {"rclpy_components": entries}, {"strangers_parts.py": STRANGERS})
    ros.env["PYTHONPATH"] = str(site)
    (ros.folder / "far.launch.yaml").write_text(LAUNCH, encoding="utf-8")
    launch = ros.spawn("launch far.launch.yaml")
    launch.wait_for_line("Loaded node '/far/managed' in container '/far/box'")
    assert [line for line in launch.stdout.splitlines() if "_composable_nodes]" in line] == [
        "[ERROR] [launch_ros.actions.load_composable_nodes]: Failed to load node 'eye' of type "
        "'strangers::Eye' in container '/far/box': Component constructor threw an exception: "
        "no camera at /dev/video0",
        "[INFO] [launch_ros.actions.load_composable_nodes]: Loaded node '/far/listener' in "
        "container '/far/box'",
        "[INFO] [launch_ros.actions.load_composable_nodes]: Loaded node '/far/managed' in "
        "container '/far/box'",
    ]

    def is_active(name):
        asked = f"service call {name}/get_state lifecycle_msgs/srv/GetState"
        return "label='active'" in ros.run(asked).stdout

    eventually(lambda: is_active("/far/arm") and is_active("/far/managed"))
    launch.interrupt()
    assert launch.wait() == 0
    assert launch.stdout.count("Traceback") == 1  # that of the constructor


def test_who_waits_for_a_container_that_never_comes_is_ended_by_ctrl_c(ros):
    text = "launch:\n- load_composable_node: {target: gone, composable_node: [{pkg: a, plugin: b}]}"
    (ros.folder / "wait.launch.yaml").write_text(text, encoding="utf-8")
    launch = ros.spawn("launch wait.launch.yaml")
    launch.wait_for_line("Default logging verbosity")
    launch.interrupt()
    assert launch.wait() == 0


def test_a_launch_in_the_background_is_up_once_its_components_are_loaded(ros):
    text = """
        launch:
        - node_container:
            pkg: rclpy_components
            exec: component_container
            name: box
            composable_node: [{pkg: strangers, plugin: "strangers::Slow"}]
        """
    slow = """
        import os
        import socket
        from rclpy.node import Node

        class Slow(Node):
            def __init__(self):
                with socket.create_connection(("127.0.0.1", int(os.environ["GATE"]))) as gate:
                    gate.recv(1)
                super().__init__("slow")
        """
    entries = {"strangers::Slow": "strangers_parts:Slow"}
    site = ros.folder / "site"
    install(site, "strangers", {"rclpy_components": entries}, {"strangers_parts.py": slow})
    gate = socket.create_server(("127.0.0.1", 0))
    gate.settimeout(LONGEST_WAIT_S)
    ros.env.update(PYTHONPATH=str(site), GATE=str(gate.getsockname()[1]))
    (ros.folder / "slow.launch.yaml").write_text(dedent(text), encoding="utf-8")
    launch = ros.spawn("launch -d slow.launch.yaml")
    with gate, gate.accept()[0] as loading:
        launch.wait_for_line("component_container-1 is up: /box")
        assert ros.run("node list").stdout == "/box\n"
        assert launch.returncode is None
        loading.send(b"!")
        assert launch.wait() == 0
    assert ros.run("component list").stdout == "/box\n  1  /slow\n"
    assert ros.run("stop slow").returncode == 0
