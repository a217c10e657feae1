"""Completion: scripts for the shells, and candidates."""

import os
import shlex
import shutil
import subprocess
import sys
from functools import partial

import pytest

from teleopctl import plugins
from teleopctl.cli import main
from teleopctl.cli.completion import completing
from teleopctl.cli.console import COMPLETION_VARIABLE
from teleopctl.cli.verb import Group, Option, parameters
from teleopctl.testing import eventually
from tests.packages.prefix import write


@pytest.mark.parametrize(
    ("shell", "mark"),
    [
        ("bash", "complete -o default"),
        ("zsh", "#compdef teleopctl"),
        ("fish", "complete --command teleopctl"),
        ("powershell", "Register-ArgumentCompleter"),
    ],
)
def test_each_shell_has_a_script(capsys, monkeypatch, shell, mark):
    monkeypatch.setenv(COMPLETION_VARIABLE, "")
    monkeypatch.delenv(COMPLETION_VARIABLE)
    status: object
    try:
        status = main.run(["completion", shell])
    except SystemExit as end:
        status = end.code
    assert not status
    script = capsys.readouterr().out
    assert mark in script
    assert COMPLETION_VARIABLE in script


def candidates(monkeypatch, capsys, line: str) -> list[str]:
    words = line.split(" ")
    monkeypatch.setenv(COMPLETION_VARIABLE, "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    with pytest.raises(SystemExit):
        main.run([])
    return str(capsys.readouterr().out).split()


def test_verbs_and_options_are_completed(monkeypatch, capsys):
    assert candidates(monkeypatch, capsys, "teleopctl topi") == ["topic"]
    assert "echo" in candidates(monkeypatch, capsys, "teleopctl topic ")
    assert candidates(monkeypatch, capsys, "teleopctl topic list --sh") == ["--show-types"]


def test_live_nodes_and_the_types_of_a_topic_are_completed(ros, monkeypatch, capsys):
    talker = ros.spawn("run teleop_py_pkg simple_publisher")
    talker.wait_for_line("Publishing")
    assert candidates(monkeypatch, capsys, "teleopctl node info /si") == ["/simple_publisher"]
    assert candidates(monkeypatch, capsys, "teleopctl topic echo chatter ") == [
        "std_msgs/msg/String"
    ]


def test_frames_and_what_runs_in_the_background_are_completed(ros, monkeypatch, capsys):
    ros.run("run --detach tf2_ros static_transform_publisher --frame-id map --child-frame-id odom")
    # A node may be up some moments before its topics are.
    eventually(lambda: ros.run("topic echo --once /tf_static").returncode == 0)
    assert candidates(monkeypatch, capsys, "teleopctl tf echo map o") == ["odom"]
    assert candidates(monkeypatch, capsys, "teleopctl stop st") == ["static_transform_publisher"]
    assert candidates(monkeypatch, capsys, "teleopctl logs st") == ["static_transform_publisher"]


def test_controllers_are_completed(ros, monkeypatch, capsys):
    line = "teleopctl control set_controller_state "
    assert candidates(monkeypatch, capsys, line) == []
    up = ros.run("launch --detach controller.yaml")
    assert up.returncode == 0, up.stderr
    assert set(candidates(monkeypatch, capsys, line)) == {
        "joint_state_broadcaster",
        "arm_controller",
        "gripper_controller",
    }


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
    # Bash takes the value of an argument for a word of its own.
    line = "teleopctl launch -d sim.yaml paused := true ca"
    assert candidates(monkeypatch, capsys, line) == ["camera:="]
    assert candidates(monkeypatch, capsys, "teleopctl launch broken.yaml ") == []


def test_bags_are_completed(monkeypatch, capsys, tmp_path):
    (tmp_path / "my_bag").mkdir()
    for name in ("my_bag/my_bag_0.mcap", "my_bag/metadata.yaml", "my_old.bag", "my_text.txt"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    assert candidates(monkeypatch, capsys, "teleopctl bag info my") == ["my_bag", "my_old.bag"]
    assert candidates(monkeypatch, capsys, "teleopctl bag info my_bag/") == ["my_bag/my_bag_0.mcap"]
    assert candidates(monkeypatch, capsys, "teleopctl bag info none/") == []


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_in_bash_the_value_of_an_argument_follows_at_once(capsys):
    main.run(["completion", "bash"])
    script = capsys.readouterr().out
    program = (
        'compopt() { echo compopt "$@"; }\n'
        f"teleopctl() {{ {shlex.quote(sys.executable)} -m teleopctl; }}\n"
        f"{script}\n"
        "COMP_WORDS=(teleopctl launch sim.yaml cam); COMP_CWORD=3\n"
        '_teleopctl_completion teleopctl; echo "${COMPREPLY[@]}"\n'
    )
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout == "compopt -o nospace\ncamera:=\n", done.stderr


def test_without_a_router_nothing_is_offered(monkeypatch, capsys):
    monkeypatch.setenv("TELEOPCTL_ROUTER", "tcp/127.0.0.1:1")
    assert candidates(monkeypatch, capsys, "teleopctl topic info /") == []


def verbs() -> list[tuple[str, ...]]:
    """The beginnings of all command lines: nouns, and nouns with their verbs."""
    found: list[tuple[str, ...]] = [()]
    for name in plugins.VERBS.ours:
        verb = plugins.load(plugins.VERBS, name)
        found.append((name,))
        found += [(name, one) for one in verb.verbs] if isinstance(verb, Group) else []
    return found


def typers_candidates(monkeypatch, capsys, words: tuple[str, ...], incomplete: str) -> list[str]:
    with monkeypatch.context() as patch:
        patch.setattr(completing, "answer", lambda: False)
        return candidates(patch, capsys, " ".join(["teleopctl", *words, incomplete]))


@pytest.mark.parametrize("words", verbs(), ids=" ".join)
def test_what_is_offered_without_typer_is_what_typer_offers(monkeypatch, capsys, tmp_path, words):
    monkeypatch.chdir(tmp_path)
    lines = [(words, ""), (words, "t"), ((*words, "x"), ""), ((*words, "x", "y"), "")]
    verb = plugins.load(plugins.VERBS, words[0]) if words else None
    if isinstance(verb, Group):
        verb = verb.verbs[words[1]] if len(words) > 1 else None
    for parameter in parameters(verb.load()) if verb else ():
        declaration = parameter.declaration
        is_known = bool(declaration.complete or declaration.choices)
        if isinstance(declaration, Option) and not declaration.alone and is_known:
            flag = declaration.flags[-1]
            # Typer takes the second value of a list for an argument.
            lines += [((*words, flag), ""), ((*words, flag, "1"), "")][: 1 if parameter.many else 2]
    for before, incomplete in lines:
        quick = completing.candidates(list(before), incomplete)
        if quick is not None:
            typers = typers_candidates(monkeypatch, capsys, before, incomplete)
            assert sorted(quick) == sorted(typers), (before, incomplete)


def test_packages_their_programs_and_their_tags_are_completed(monkeypatch, capsys, tmp_path):
    write(tmp_path / "arm/package.xml", "<package><name>arm</name><version>1</version></package>")
    script = "from setuptools import setup\nsetup(entry_points={'console_scripts': ['go = arm:f']})"
    write(tmp_path / "arm/setup.py", script)
    monkeypatch.chdir(tmp_path)
    offered = partial(candidates, monkeypatch, capsys)
    assert offered("teleopctl pkg prefix ar") == ["arm"]
    assert offered("teleopctl pkg create new --dependencies rclpy ar") == ["arm"]
    assert offered("teleopctl run ar") == ["arm"]
    assert offered("teleopctl run arm ") == ["go"]
    assert offered("teleopctl pkg xml arm --tag ") == ["name", "version"]
    assert offered("teleopctl pkg create --license MIT") == ["MIT", "MIT-0"]
    assert offered("teleopctl pkg create --build-type ament_p") == ["ament_python"]


def test_a_plain_line_is_completed_without_typer_and_the_metadata_of_distributions():
    code = (
        "import sys; from teleopctl.cli import main\ntry:\n    main.run([])\nfinally:\n"
        "    print(sorted({'typer', 'rich', 'importlib.metadata'} & set(sys.modules)))"
    )
    line = {"COMP_WORDS": "teleopctl pkg prefix teleop_d", "COMP_CWORD": "3"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **line, COMPLETION_VARIABLE: "complete_bash"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "teleop_description\n[]\n"
