"""Completion: what Tab offers, and how it is written for bash."""

import os
import shlex
import shutil
import subprocess
import sys
from functools import partial

import pytest
from hypothesis import given, strategies as st

from teleopctl.cli import main
from teleopctl.cli.completion import completing, shells
from teleopctl.cli.console import COMPLETION_VARIABLE
from teleopctl.cli.verb import Option, parameters
from teleopctl.interfaces import get_message, list_types, message_from_yaml
from teleopctl.testing import eventually
from tests.cli.verb_paths import verbs
from tests.packages.prefix import write
from tests.samples import sample

WORD_BREAKS = " \t\n\"'><=;|&(:"
TF = "tf2_msgs/msg/TFMessage"


def candidates(monkeypatch, capsys, line: str) -> list[str]:
    monkeypatch.setenv(COMPLETION_VARIABLE, "bash")
    assert main.run(["--", line, WORD_BREAKS]) == 0
    return str(capsys.readouterr().out).splitlines()


def test_verbs_and_options_are_completed(monkeypatch, capsys):
    assert candidates(monkeypatch, capsys, "teleopctl topi") == ["topic"]
    assert "echo" in candidates(monkeypatch, capsys, "teleopctl topic ")
    assert candidates(monkeypatch, capsys, "teleopctl topic list --sh") == ["--show-types"]


def test_live_nodes_and_the_types_of_a_topic_are_completed(ros, monkeypatch, capsys):
    talker = ros.spawn("run teleop_py_pkg simple_publisher")
    talker.wait_for_line("Publishing")
    # A node may be in the graph some moments before its topics are.
    eventually(
        lambda: (
            candidates(monkeypatch, capsys, "teleopctl topic echo chatter ")
            == ["std_msgs/msg/String"]
        )
    )
    assert candidates(monkeypatch, capsys, "teleopctl node info /si") == ["/simple_publisher"]


def test_frames_and_what_runs_in_the_background_are_completed(ros, monkeypatch, capsys):
    ros.run("run --detach tf2_ros static_transform_publisher --frame-id map --child-frame-id odom")
    # A node may be up some moments before its topics are.
    eventually(lambda: ros.run("topic echo --once /tf_static").returncode == 0)
    assert candidates(monkeypatch, capsys, "teleopctl tf echo map o") == ["odom"]
    assert candidates(monkeypatch, capsys, "teleopctl stop st") == ["static_transform_publisher"]
    assert candidates(monkeypatch, capsys, "teleopctl logs st") == ["static_transform_publisher"]


def test_controllers_hardware_and_managers_are_completed(ros, monkeypatch, capsys):
    def offered(line):
        return set(candidates(monkeypatch, capsys, f"teleopctl control {line}"))

    verb = "set_controller_state "
    assert offered(verb) == offered("doctor -c ") == set()
    up = ros.run("launch --detach controller.yaml")
    assert up.returncode == 0, up.stderr
    controllers = {"joint_state_broadcaster", "arm_controller", "gripper_controller"}
    assert offered(verb) == offered("plot -c /controller_manager ") == controllers
    assert offered("load_controller ") == controllers
    assert offered("doctor -c /nobody ") == offered("switch_controllers --activate ") == set()
    assert offered("switch_controllers --deactivate arm") == {"arm_controller"}
    assert offered("top -c ") == {"/controller_manager"}
    assert offered("set_hardware_component_state ") == {"RobotSystem"}


def test_launch_files_their_packages_and_their_arguments_are_completed(
    monkeypatch, capsys, tmp_path
):
    folder = tmp_path / "my_pkg" / "launch"
    folder.mkdir(parents=True)
    (folder.parent / "package.xml").write_text("<package><name>my_pkg</name></package>")
    (folder / "up.yaml").write_text("launch:\n- arg: {name: who, default: a}\n")
    (folder / "again.launch.xml").write_text("<launch><arg name='what'/></launch>")
    (folder / "old.launch.py").touch()
    (folder / "helpers.py").touch()
    (tmp_path / "setup.py").touch()
    (tmp_path / "broken.yaml").write_text("launch: [")
    monkeypatch.chdir(tmp_path)
    offered = candidates(monkeypatch, capsys, "teleopctl launch ")
    assert {"sim.yaml", "broken.yaml", "my_pkg"} <= set(offered)
    assert not {"teleop_py_pkg", "setup.py"} & set(offered)
    of_package = candidates(monkeypatch, capsys, "teleopctl launch my_pkg ")
    assert of_package == ["again.launch.xml", "old.launch.py", "up.yaml"]
    line = "teleopctl launch my_pkg again.launch.xml "
    assert candidates(monkeypatch, capsys, line) == ["what:="]
    assert candidates(monkeypatch, capsys, "teleopctl launch my_pkg up.yaml ") == ["who:="]
    line = "teleopctl launch -d sim.yaml paused:=true ca"
    assert candidates(monkeypatch, capsys, line) == ["camera:="]
    assert candidates(monkeypatch, capsys, "teleopctl launch broken.yaml ") == []


def test_bags_are_completed(monkeypatch, capsys, tmp_path):
    (tmp_path / "my_bag").mkdir()
    for name in ("my_bag/my_bag_0.mcap", "my_bag/metadata.yaml", "my_old.bag", "my_text.txt"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    assert candidates(monkeypatch, capsys, "teleopctl bag info my") == ["my_bag", "my_old.bag"]
    assert candidates(monkeypatch, capsys, "teleopctl bag info my_bag/") == ["my_bag/my_bag_0.mcap"]
    assert candidates(monkeypatch, capsys, "teleopctl bag info ./my_o") == ["./my_old.bag"]
    assert candidates(monkeypatch, capsys, "teleopctl bag info none/") == []


def test_without_a_router_nothing_is_offered(monkeypatch, capsys):
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/127.0.0.1:1")
    assert candidates(monkeypatch, capsys, "teleopctl topic info /") == []


@pytest.mark.parametrize("path", sample(verbs(), 4), ids=" ".join)
def test_every_option_is_offered_and_every_choice(path):
    for parameter in parameters(verbs()[path].load()):
        declaration = parameter.declaration
        if isinstance(declaration, Option):
            for flag in declaration.flags:
                assert flag in completing.candidates(path, flag)
            if parameter.takes_value and declaration.choices:
                flag = declaration.flags[-1]
                offered = completing.candidates([*path, flag], "")
                assert set(declaration.choices) <= set(offered)
                spelt = completing.candidates(path, f"{flag}={declaration.choices[0]}")
                assert f"{flag}={declaration.choices[0]}" in spelt


def test_a_program_has_the_options_behind_its_name_to_itself():
    assert completing.candidates(["run"], "--pre") == ["--prefix"]
    assert completing.candidates(["run", "pkg", "program"], "--pre") == []


@given(st.lists(st.text(alphabet="ab'\"\\ $!:={}/*"), min_size=1))
def test_a_line_is_split_as_a_shell_splits_it(words):
    line = " ".join(map(shlex.quote, words))
    asked = shells.split_line(f"{line} ")
    assert (asked.words, asked.incomplete, asked.quote) == (words, "", "")
    assert shells.split_line(line).incomplete == words[-1]


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@given(st.lists(st.text(alphabet="ab'\"\\ $`!:={}/*", min_size=1), min_size=9))
def test_a_candidate_is_quoted_so_that_bash_reads_it_as_it_is(names):
    asked = {
        quote: shells.split_line(f"teleopctl {quote}", WORD_BREAKS) for quote in ("", "'", '"')
    }
    words = [
        quote + shells.format_candidate("bash", line, name) + quote
        for name in names
        for quote, line in asked.items()
    ]
    program = f"printf '%s\\n' {' '.join(words)}"
    read = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=True)
    assert read.stdout.splitlines() == [name for name in names for _ in range(3)]


def test_what_bash_leaves_as_it_is_is_not_repeated():
    asked = shells.split_line("teleopctl launch world:=/a", WORD_BREAKS)
    assert shells.format_candidate("bash", asked, "world:=/a b") == "/a\\ b"


def test_a_whole_message_request_or_goal_is_offered(monkeypatch, capsys):
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/127.0.0.1:1")
    offered = partial(completing.candidates, incomplete="")
    point = "{header: {stamp: {sec: 0, nanosec: 0}, frame_id: ''}, point: {x: 0.0, y: 0.0, z: 0.0}}"
    assert offered(["topic", "pub", "/p", "geometry_msgs/msg/PointStamped"]) == [point]
    assert offered(["service", "call", "/s", "std_srvs/srv/SetBool"]) == ["{data: false}"]
    assert offered(["action", "send_goal", "/a", "example_interfaces/action/Fibonacci"]) == [
        "{order: 0}"
    ]
    assert offered(["topic", "pub", "/p", "no_msgs/msg/Such"]) == []
    assert "std_srvs/srv/SetBool" in offered(["service", "call", "/s"])


@given(st.sampled_from(list_types("msg")))
def test_a_prototype_is_the_message_itself(type_name):
    (text,) = completing.candidates(["topic", "pub", "/x", type_name], "")
    assert message_from_yaml(get_message(type_name), text) == get_message(type_name)()


def test_fields_are_offered_down_to_the_one_that_is_typed(monkeypatch):
    def offered(incomplete):
        return completing.candidates(["topic", "echo", "/tf", TF, "--field"], incomplete)

    assert offered("tr") == ["transforms", "transforms[0]", "transforms[0]."]
    assert offered("transforms[0].header.st") == [
        "transforms[0].header.stamp",
        "transforms[0].header.stamp.",
    ]
    assert offered("transforms[0].transform.rotation.") == [
        f"transforms[0].transform.rotation.{axis}" for axis in "xyzw"
    ]
    assert offered("nothing.") == []


def test_files_are_offered_where_a_file_is_meant(monkeypatch, tmp_path):
    (tmp_path / "folder" / "inner").mkdir(parents=True)
    (tmp_path / "folder" / "a file.yaml").touch()
    (tmp_path / ".hidden").touch()
    monkeypatch.chdir(tmp_path)
    offered = partial(completing.candidates, ["graph", "--svg"])
    assert offered("") == ["folder/"]
    assert offered(".h") == [".hidden"]
    assert offered("folder/") == ["folder/a file.yaml", "folder/inner/"]
    assert offered(f"{tmp_path}/fo") == [f"{tmp_path}/folder/"]
    assert completing.candidates(["run", "./node.py"], "folder/a") == ["folder/a file.yaml"]


PARAMETERS = """
import rclpy
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
rclpy.init()
node = rclpy.create_node("tuned")
few = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=6, step=2)])
node.declare_parameter("few", 4, few)
node.declare_parameter("names", ["a", "b c"])
node.declare_parameter("text", "1.0")
node.get_logger().info("ready")
rclpy.spin(node)
"""


def test_values_of_a_parameter_and_fields_of_a_live_topic_are_offered(ros, monkeypatch):
    (ros.folder / "tuned.py").write_text(PARAMETERS)
    ros.spawn("run ./tuned.py").wait_for_line("ready")

    def offered(name):
        return completing.candidates(["param", "set", "tuned", name], "")

    # A node of a busy machine may answer later than a person who presses Tab would wait.
    eventually(lambda: offered("use_sim_time") == ["false", "true"])
    eventually(lambda: offered("few") == ["4", "0", "2", "6"])
    eventually(lambda: offered("names") == ["[a, b c]"])
    eventually(lambda: offered("text") == ["'1.0'"])
    assert offered("none") == []
    field = partial(completing.candidates, ["topic", "echo", "/rosout", "--field"], "sta")
    eventually(lambda: field() == ["stamp", "stamp."])


def test_packages_their_programs_and_their_tags_are_completed(monkeypatch, capsys, tmp_path):
    write(tmp_path / "arm/package.xml", "<package><name>arm</name><version>1</version></package>")
    script = "from setuptools import setup\nsetup(entry_points={'console_scripts': ['go = arm:f']})"
    write(tmp_path / "arm/setup.py", script)
    monkeypatch.chdir(tmp_path)
    offered = partial(candidates, monkeypatch, capsys)
    assert offered("teleopctl pkg prefix arm") == ["arm"]
    assert offered("teleopctl pkg create new --dependencies rclpy arm") == ["arm"]
    assert offered("teleopctl run ar") == ["arm"]
    assert offered("teleopctl run arm ") == ["go"]
    assert offered("teleopctl pkg xml arm --tag ") == ["name", "version"]
    assert offered("teleopctl pkg create --license MIT") == ["MIT", "MIT-0"]
    assert offered("teleopctl pkg create --build-type ament_p") == ["ament_python"]


def test_a_plain_line_is_completed_without_typer_and_the_metadata_of_distributions():
    code = (
        "import sys; from teleopctl.cli import main\ntry:\n    main.run(sys.argv[1:])\nfinally:\n"
        "    print(sorted({'typer', 'rich', 'importlib.metadata'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "--", "pkg", "prefix", "teleop_des"],
        env={**os.environ, COMPLETION_VARIABLE: "zsh"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "teleop_description\n[]\n"
