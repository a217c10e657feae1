"""Plug-ins of one's own: the code of each page below docs/extending, installed and used."""

import os
import re
import struct
import subprocess
import sys
import sysconfig
import threading
import tomllib
from pathlib import Path
from typing import Any

import pytest

from teleopctl import plugins
from teleopctl.interfaces.store import get_message
from teleopctl.plugins import lookup
from teleopctl.testing import ControlStack, RosGraph, eventually, serial_robot
from tests import ROOT
from tests.distributions import install
from tests.test_docs import blocks, calls, command_lines

FOLDER = ROOT / "docs" / "extending"
LONGEST_CODE = 30
FILE_NAME = re.compile(r"^(?:# |<!-- )([\w./]+\.\w+)(?: -->)?\n")
PAGES = sorted(path for path in FOLDER.glob("*.md") if path.stem != "index")

JointState = get_message("sensor_msgs/msg/JointState")
Float64 = get_message("std_msgs/msg/Float64")


def files_of(page: Path) -> dict[str, str]:
    """The files that a page shows, by name."""
    texts = blocks(page, "toml", "python", "yaml", "xml", "text")
    return {name[1]: text for text in texts if (name := FILE_NAME.match(text))}


@pytest.fixture
def use(ros: RosGraph):
    """Install what a page shows, and run the commands that it shows."""

    def use(name: str) -> list[str]:
        page = FOLDER / f"{name}.md"
        files = files_of(page)
        project = tomllib.loads(files.pop("pyproject.toml"))["project"]
        site = ros.folder / "site"
        packaged = {path for path in files if "/" in path or path.startswith("my_")}
        install(
            site, project["name"], project["entry-points"], {path: files[path] for path in packaged}
        )
        for path in files.keys() - packaged:
            (ros.folder / path).write_text(files[path], encoding="utf-8")
        # A checkout that is on the path, not installed, stays there.
        paths = [str(site), os.environ.get("PYTHONPATH", "")]
        ros.env["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        # A launch file may call teleopctl itself.
        ros.env["PATH"] = os.pathsep.join([sysconfig.get_path("scripts"), os.environ["PATH"]])
        outputs = []
        for line in command_lines(page):
            for words in calls(line):
                if "-f" in words:  # follows for ever
                    continue
                done = ros.run(words, 60)
                assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
                outputs.append(done.stdout)
        return outputs

    return use


@pytest.mark.nightly
def test_the_package_of_the_page_is_whole_when_pip_has_built_and_installed_it(tmp_path):
    pytest.importorskip("pip")
    project, site = tmp_path / "project", tmp_path / "site"
    files = files_of(FOLDER / "package.md")
    for name, text in files.items():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text(text, encoding="utf-8")
    command = ["-m", "pip", "install", "--quiet", "--no-deps", "--target", str(site), str(project)]
    done = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 0, done.stderr
    for name in files:
        if name.startswith("my_grip_msgs/"):
            assert (site / name).is_file()


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_the_code_of_a_page_is_short(page):
    for name, text in files_of(page).items():
        if name.endswith(".py"):
            assert len(text.splitlines()) <= LONGEST_CODE, name


def test_every_kind_of_plug_in_is_in_the_table_and_has_a_page():
    table = (FOLDER / "index.md").read_text(encoding="utf-8")
    groups = {kind.group for kind in plugins.kinds()}
    assert set(re.findall(r"`((?:teleopctl\.|rclpy_)\w+)` \|", table)) == groups
    # Components are ROS 2's kind of plug-in, with a page and tests of their own.
    groups.remove("rclpy_components")
    assert set(re.findall(r"\]\((\w+)\.md\)", table)) == {page.stem for page in PAGES}
    shown = {
        group
        for page in PAGES
        for group in tomllib.loads(files_of(page)["pyproject.toml"])["project"]["entry-points"]
    }
    assert shown == groups


def test_a_strangers_filter_is_part_of_a_chain(tmp_path, monkeypatch):
    files = files_of(FOLDER / "controller.md")
    project = tomllib.loads(files["pyproject.toml"])["project"]
    group = {plugins.FILTERS.group: project["entry-points"][plugins.FILTERS.group]}
    install(tmp_path, project["name"], group, {"my_filters.py": files["my_filters.py"]})
    monkeypatch.syspath_prepend(str(tmp_path))
    lookup.forget_entry_points()
    stack = ControlStack(serial_robot(1, initial=(0.25,)))
    stack.load_controller(
        "calm",
        "chained_filter_controller/ChainedFilter",
        {
            "input_interfaces": ["joint1/position"],
            "output_interfaces": ["calm"],
            "filter_chain.filter1.name": "deadband",
            "filter_chain.filter1.type": "my_filters/Deadband",
            "filter_chain.filter1.params.width": 0.5,
        },
    )
    stack.activate("calm")
    stack.step()
    assert stack.state("calm/calm") == 0.0
    lookup.forget_entry_points()


def test_a_strangers_controller_moves_a_joint(ros, use):
    outputs = use("controller")
    assert re.search(r"wave +my_controllers/Wave +active", outputs[1])
    # The page's chain: what commands comes first.
    chained = outputs[5].splitlines()
    wave, gentle = (
        next(number for number, line in enumerate(chained) if line.startswith(name))
        for name in ("wave", "gentle")
    )
    assert wave < gentle
    assert chained[wave + 2].strip() == "joint_1/position"
    types = ros.run("control list_controller_types").stdout
    assert re.search(r"my_controllers/Wave +controller_interface::ControllerInterface", types)
    assert re.search(r"Gentle +controller_interface::ChainableControllerInterface", types)
    for sign in (1.0, -1.0):
        ros.wait_for_message(
            JointState,
            "/joint_states",
            lambda m, sign=sign: sign * dict(zip(m.name, m.position, strict=True))["joint_1"] > 0.3,
        )


@pytest.mark.nightly
def test_a_strangers_hardware_is_driven(ros, use):
    _, listed, _ = use("hardware")
    assert "plugin name: my_servos/Servos" in listed
    message = ros.wait_for_message(
        JointState,
        "/joint_states",
        lambda m: abs(dict(zip(m.name, m.position, strict=True))["joint_4"] + 1.0) < 1e-3,
    )
    assert message


@pytest.mark.nightly
def test_a_strangers_sensor_measures_in_the_simulation(use):
    *_, received = use("sensor")
    assert float(received.split()[1]) == pytest.approx(2.5, abs=1e-3)


@pytest.mark.skipif(os.name == "nt", reason="a named pipe")
def test_a_strangers_device_drives_a_base(ros, use, monkeypatch):
    from teleopctl.node import Parameter, SingleThreadedExecutor, init, try_shutdown
    from teleopctl.nodes.teleop.device_node import DeviceNode

    (listed,) = use("device")
    assert re.search(r"^spacemouse +from my-devices$", listed, re.MULTILINE)
    monkeypatch.syspath_prepend(str(ros.folder / "site"))
    lookup.forget_entry_points()
    pipe = ros.folder / "hidraw0"
    os.mkfifo(pipe)
    writer = os.open(pipe, os.O_RDWR)
    twists: list[Any] = []
    kind = get_message("geometry_msgs/msg/Twist")
    ros.node.create_subscription(kind, "/cmd_vel", twists.append, 10)
    init(args=[])
    given = {"device": "spacemouse", "path": str(pipe), "cmd_vel": "/cmd_vel"}
    executor = SingleThreadedExecutor()
    try:
        with DeviceNode([Parameter(name, value=value) for name, value in given.items()]) as node:
            executor.add_node(node)
            threading.Thread(target=executor.spin, daemon=True).start()
            eventually(lambda: node.driver.is_base)

            def pushed() -> bool:
                os.write(writer, struct.pack("<B3h", 1, 0, -350, 0))
                return any(twist.linear.x == 0.25 for twist in twists)

            eventually(pushed)
            # Silence is release.
            eventually(lambda: twists[-1].linear.x == 0.0)
    finally:
        os.close(writer)
        try_shutdown()
        lookup.forget_entry_points()


def test_a_strangers_verb_and_completion(ros, use):
    use("verb")
    done = ros.run("where teleop_description --launch")
    assert done.stdout.rstrip().endswith("launch"), done.stderr
    assert "(from my-verbs)" in ros.run("--help").stdout
    ros.env["_TELEOPCTL_COMPLETE"] = "zsh"
    assert {"tf2_ros", "tf2_tools"} <= set(ros.run("-- where tf2").stdout.split())


def test_a_strangers_launch_action_and_substitution(use):
    _, nodes = use("launch")
    assert nodes.split() == ["/robot_0/simple_publisher", "/robot_1/simple_publisher"]


def test_a_strangers_messages_and_launch_files(ros, use):
    use("package")
    ros.wait_for_nodes("/listener")
    ros.spawn("launch my_grip_msgs squeeze.yaml")
    ros.spawn("logs -f listen").wait_for_line("left: 2.5 N")
    assert "Type: my_grip_msgs/msg/Grip" in ros.run("topic info /grip").stdout


def test_a_strangers_node(ros, use):
    use("node")
    ros.spawn("run my_robot heartbeat --ros-args -r heartbeat:=alive")
    ros.wait_for_nodes("/heartbeat")
    ros.wait_for_message(get_message("std_msgs/msg/Empty"), "/alive")


def test_a_strangers_panel_and_display_are_on_the_page(ros, use):
    (said,) = use("viewer")
    assert "/rviz" in said
    assert "/stop" in ros.run("topic list").stdout.split()
