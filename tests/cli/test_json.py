"""``--json``: every verb has it or a reason, and what it prints is what the page says."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from functools import partial

import pytest
import yaml

from teleopctl.cli import main
from teleopctl.cli.verb import Option, parameters
from teleopctl.testing import RosGraph, eventually
from tests import ROOT
from tests.bag.bags import write_bag
from tests.cli.verb_paths import verbs

PAGE = (ROOT / "docs/json.md").read_text(encoding="utf-8")
FIBONACCI = "example_interfaces/action/Fibonacci"
CODE = re.compile(r"`([^`]+)`")
SCALARS = {"text": str, "boolean": bool, "integer": int, "number": int | float}


def table(title: str) -> dict[str, list[str]]:
    """A table of the page below a heading: the cells behind the first one, by the first one."""
    section = PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    rows = [line.strip("|").split(" | ") for line in section.splitlines() if line.startswith("| `")]
    return {CODE.findall(first)[0]: rest for first, *rest in rows}


def shapes(cell: str) -> list[object]:
    """The shapes that a cell allows."""
    return [yaml.safe_load(code) for code in CODE.findall(cell)]


PRINTED = {verb: shapes(cells[0]) for verb, cells in table("What each verb prints").items()}
LINES = {verb for verb, cells in table("What each verb prints").items() if "line" in cells[1]}
NAMED = {name: shapes(cells[0]) for name, cells in table("Shapes that have a name").items()}
WITHOUT = table("Verbs without it")


def differences(value: object, shape: object, place: str = "$") -> Iterator[str]:
    """Where a value is not as a shape of the page says."""
    if isinstance(shape, list):
        if not isinstance(value, list):
            yield f"{place}: no list but {value!r}"
        else:
            for number, element in enumerate(value):
                yield from differences(element, shape[0], f"{place}[{number}]")
    elif isinstance(shape, dict):
        yield from _of_object(value, shape, place)
    elif isinstance(shape, str):
        *others, last = shape.split(" or ")
        if others and last == "null":
            if value is not None:
                yield from differences(value, " or ".join(others), place)
        elif shape in NAMED or shape in PRINTED:
            yield from _of_any(value, NAMED.get(shape) or PRINTED[shape], place)
        elif shape == "message":
            if not isinstance(value, dict):
                yield f"{place}: no message but {value!r}"
        elif shape != "any" and (
            not isinstance(value, SCALARS[shape]) or isinstance(value, bool) != (shape == "boolean")
        ):
            yield f"{place}: no {shape} but {value!r}"
    elif value is not None:
        yield f"{place}: not null but {value!r}"


def _of_any(value: object, allowed: list[object], place: str) -> Iterator[str]:
    found = [list(differences(value, shape, place)) for shape in allowed]
    if all(found):
        yield from min(found, key=len)


def _of_object(value: object, shape: dict[str, object], place: str) -> Iterator[str]:
    if not isinstance(value, dict):
        yield f"{place}: no object but {value!r}"
        return
    if "NAME" in shape:
        for name, element in value.items():
            yield from differences(element, shape["NAME"], f"{place}.{name}")
        return
    for name, inner in shape.items():
        key = name.rstrip("*")
        if key in value:
            yield from differences(value[key], inner, f"{place}.{key}")
        elif key == name:
            yield f"{place}: {key} is missing"
    for key in value.keys() - {name.rstrip("*") for name in shape}:
        yield f"{place}: {key} is not on the page"


def has_json(path: tuple[str, ...]) -> bool:
    declared = (parameter.declaration for parameter in parameters(verbs()[path].load()))
    return any("--json" in each.flags for each in declared if isinstance(each, Option))


def test_every_verb_has_json_or_a_reason_and_stands_on_the_page():
    every = {" ".join(path): has_json(path) for path in verbs()}
    assert PRINTED.keys() == {verb for verb, is_there in every.items() if is_there}
    assert WITHOUT.keys() == {verb for verb, is_there in every.items() if not is_there}
    assert all(reason.strip(" |") for (reason,) in WITHOUT.values())


@pytest.mark.parametrize(
    ("value", "shape", "count"),
    [
        ({"a": 1, "b": [True]}, {"a": "integer", "b": ["boolean"], "c*": "text"}, 0),
        ({"a": 1.5}, {"a": "integer"}, 1),
        ({"a": True}, {"a": "number"}, 1),
        ({"a": None}, {"a": "text or null"}, 0),
        ({"b": 1}, {"a": "any"}, 2),
        ({"x": ["a"], "y": [1]}, {"NAME": ["text"]}, 1),
    ],
)
def test_a_value_that_is_not_as_the_page_says_is_noticed(value, shape, count):
    assert len(list(differences(value, shape))) == count


# One line each, in this order, since some change something. BAG is a bag, NEW a name that is free.
COMMANDS = f"""
ps
node list
node info /simple_publisher
topic list
topic info /chatter
topic echo /chatter --once
topic echo /chatter /rosout --once -i
topic type /chatter
topic find std_msgs/msg/String
topic pub --once -w 0 /said std_msgs/msg/String "{{data: hello}}"
graph
param list /simple_publisher
param list /simple_publisher --param-type
param get /simple_publisher use_sim_time
param describe /simple_publisher use_sim_time
param dump /simple_publisher
param set /simple_publisher use_sim_time false
param set /simple_publisher use_sim_time false --atomic
param save NEW /simple_publisher
param restore parameters.yaml
param load /simple_publisher parameters.yaml
param delete /deleting one
service list
service type /simple_publisher/get_parameters
service info /simple_publisher/get_parameters
service find rcl_interfaces/srv/GetParameters
service call /lively/get_state lifecycle_msgs/srv/GetState
action list
action info /fib
action type /fib
action find {FIBONACCI}
action send_goal -f /fib {FIBONACCI} "{{order: 3}}"
action goals /fib -a
action cancel /fib
logger list
logger get simple_publisher
logger set simple_publisher info
wait topic /chatter --timeout 5
wait node /simple_publisher --timeout 5
wait service /simple_publisher/get_parameters --timeout 5
wait action /fib --timeout 5
wait tf world base_link --timeout 5
wait message /chatter --timeout 5
version
lifecycle nodes
lifecycle get
lifecycle list /lively
lifecycle set /lively configure
component types
component list
component list --containers-only
component load /ComponentManager composition composition::Talker
component unload /ComponentManager 1
control list_controllers
control list_controller_types
control list_hardware_components
control list_hardware_interfaces
control top --once --window 0.2
control doctor
control plot arm_controller --window 0.2
kinematics fk
kinematics ik 0 0.8 1.4
kinematics jacobian
kinematics workspace --samples 100
kinematics srdf --samples 100
move --named zero --gripper open
move --joints joint_1=0.2 --dry-run
control set_controller_state gripper_controller inactive
control switch_controllers --activate gripper_controller
control set_controller_state gripper_controller inactive
control cleanup_controller gripper_controller
control load_controller gripper_controller --set-state inactive
control set_controller_state gripper_controller unconfigured
control unload_controller gripper_controller
control load_controller gripper_controller
control set_hardware_component_state RobotSystem inactive
control reload joint_state_broadcaster
control reload_controller_libraries --force-kill
control view_controller_chains -o NEW
tf echo base_link world --once
tf list
tf monitor --once -t 0.1
tf view_frames -t 0.1 -o NEW
interface list
interface package std_msgs
interface packages
interface show std_msgs/msg/Header
interface proto std_msgs/msg/Header
interface stubs NEW --all
pkg list
pkg executables teleop_py_pkg
pkg prefix teleop_description
robot check robot.urdf --simulate
pkg xml carried
pkg xml carried -t version
pkg create made
pkg create --license ?
doctor check
doctor hello -1 -pp 0.1
multicast send
daemon start
daemon status
extensions
extension_points
plugin list
bag list storage
bag info BAG
bag check BAG
bag cut BAG -o NEW --duration 0.05
bag filter BAG -o NEW --topics /topic_0
bag merge BAG BAG -o NEW
bag convert -i BAG -o NEW
bag reindex BAG
bag recover BAG -o NEW
bag export BAG -o NEW
"""
# These go on until Ctrl-C: what they print first counts.
STREAMS = ("topic hz /chatter", "topic bw /chatter", "topic delay /stamped", "logger watch")
# These end what the others need, so that they have a graph of their own.
ENDS = ("node kill /simple_publisher", "stop --yes", "daemon stop")
# What needs a camera, a recorded simulation, a second machine or hardware with a status.
ELSEWHERE = {
    "sim sweep": "tests/sweep/test_sweep.py",
    "sim pause": "tests/system/test_simulation_interfaces.py",
    "sim play": "tests/system/test_simulation_interfaces.py",
    "sim step": "tests/system/test_simulation_interfaces.py",
    "sim reset": "tests/system/test_simulation_interfaces.py",
    "sim list": "tests/system/test_simulation_interfaces.py",
    "sim spawn": "tests/system/test_simulation_interfaces.py",
    "sim delete": "tests/system/test_simulation_interfaces.py",
    "sim save": "tests/system/test_simulation_interfaces.py",
    "sim load": "tests/system/test_simulation_interfaces.py",
    "camera save": "tests/system/test_camera_save.py",
    "bag verify": "tests/system/test_bag_verify.py",
    **dict.fromkeys(
        [f"episode {verb}" for verb in ("list", "stats", "replay", "trim", "drop", "build")],
        "tests/system/test_episodes.py",
    ),
    "multicast receive": "tests/system/test_doctor.py",
    "control view_hardware_status": "tests/system/test_control.py",
    "service echo": "tests/system/test_service.py",
    "action echo": "tests/system/test_action.py",
    "ros2 install": "tests/cli/verbs/test_ros2.py",
    "ros2 remove": "tests/cli/verbs/test_ros2.py",
    "wtf check": "the same as doctor check",
    "wtf hello": "the same as doctor hello",
}


DELETING = """
import rclpy
from rcl_interfaces.msg import ParameterDescriptor
rclpy.init()
node = rclpy.create_node("deleting", allow_undeclared_parameters=True)
node.declare_parameter("one", 1, ParameterDescriptor(dynamic_typing=True))
rclpy.spin(node)
"""


@pytest.fixture(scope="module")
def graph(shared_ros: RosGraph) -> RosGraph:
    """A robot with controllers and a node of every kind; its folder holds a bag and a package."""
    folder = shared_ros.folder
    write_bag(folder / "bag")
    manifest = "<package format='3'><name>carried</name><version>1.0.0</version></package>"
    (folder / "carried").mkdir()
    (folder / "robot.urdf").write_text('<robot name="post"><link name="world"/></robot>')
    (folder / "deleting.py").write_text(DELETING)
    (folder / "parameters.yaml").write_text(
        "/simple_publisher:\n  ros__parameters: {use_sim_time: false}\n"
    )
    (folder / "carried/package.xml").write_text(manifest)
    for line in (
        "launch --detach controller.yaml",
        "run --detach --logger-services teleop_py_pkg simple_publisher",
        f"run --detach {ROOT}/tests/system/action_server.py",
        f"run --detach {ROOT}/tests/compat/programs/lifecycle.py",
        "run --detach rclpy_components component_container",
        f"run --detach {folder}/deleting.py",
        "run --detach tf2_ros static_transform_publisher --frame-id world "
        "--child-frame-id base_link",
    ):
        up = shared_ros.run(line, timeout=60)
        assert up.returncode == 0, up.stderr
    for line in ("lifecycle get lively", "component list /ComponentManager", "action type /fib"):
        eventually(partial(_succeeds, line), what=line)
    return shared_ros


def _succeeds(line: str) -> bool:
    return main.run(line.split()) == 0


def test_what_every_verb_prints_is_as_the_page_says(graph, capsys, monkeypatch):
    monkeypatch.chdir(graph.folder)
    seen = set()
    wrong = []
    for number, line in enumerate(COMMANDS.split("\n")[1:-1]):
        words = shlex.split(line.replace("BAG", "bag").replace("NEW", f"new_{number}"))
        capsys.readouterr()
        status = main.run([*words, "--json"])
        written, errors = capsys.readouterr()
        verb = verb_of(words)
        seen.add(verb)
        wrong += [f"{line}: {text}" for text in faults(verb, written)]
        if status:
            wrong.append(f"{line}: status {status}: {errors}")
    assert not wrong
    others = {verb_of(line.split()) for line in (*STREAMS, *ENDS)}
    assert seen | others | ELSEWHERE.keys() == PRINTED.keys()


def verb_of(words: list[str]) -> str:
    return words[0] if words[0] in PRINTED else " ".join(words[:2])


def faults(verb: str, written: str) -> Iterator[str]:
    """What is wrong with the output of a verb."""
    documents = written.splitlines() if verb in LINES else [written]
    if not documents:
        yield "nothing"
    for document in documents:
        try:
            yield from _of_any(json.loads(document), PRINTED[verb], "$")
        except ValueError:
            yield f"no JSON: {document[:200]!r}"


STAMPED = "topic pub -r 20 /stamped geometry_msgs/msg/PointStamped '{header: auto}'"
# Logs each second. What the other nodes have logged is kept on /rosout for 10 s only.
LOGGING = "run demo_nodes_py talker"


def test_a_verb_that_goes_on_prints_an_object_a_line(graph):
    graph.spawn(STAMPED)
    graph.spawn(LOGGING)
    processes = [(line, graph.spawn(f"{line} --json")) for line in STREAMS]
    for line, process in processes:
        # While nothing has come yet, nothing is printed.
        written = process.wait_for_line(r"^\{.*\}$", stream="stdout").string
        process.interrupt()
        assert not list(faults(verb_of(line.split()), written.strip()))


def test_an_error_is_a_text_on_stderr_and_stdout_stays_empty(graph, capsys):
    assert main.run(["topic", "info", "/none", "--json"]) == 1
    written, errors = capsys.readouterr()
    assert written == ""
    assert errors.startswith("teleopctl: Unknown topic '/none'")


def test_a_verb_that_ends_things_says_what_it_has_ended(ros_with_own_router, capsys):
    ros = ros_with_own_router
    assert ros.run("run --detach teleop_py_pkg simple_publisher").returncode == 0
    for line in ENDS:
        capsys.readouterr()
        assert main.run([*line.split(), "--json"]) == 0
        assert not list(faults(verb_of(line.split()), capsys.readouterr().out))
