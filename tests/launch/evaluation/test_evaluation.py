"""From launch files to plans: arguments, scopes, conditions, nodes and their command lines."""

import os
import re
import sys

import pytest
import yaml

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends.yaml_file import parse_file
from teleopctl.launch.model.request import LaunchRequest, load_request

ARM = '<robot name="arm"><link name="base"/></robot>'


@pytest.fixture
def evaluated(tmp_path):
    def evaluated(text, **arguments):
        settings = {
            key: arguments.pop(key)
            for key in ("show_all_output", "prefix", "prefix_filter", "skip_missing")
            if key in arguments
        }
        path = tmp_path / "main.yaml"
        path.write_text(text, encoding="utf-8")
        return evaluate(
            parse_file(path), arguments, tmp_path / "log", LaunchRequest(file=str(path), **settings)
        )

    return evaluated


@pytest.fixture
def plan(evaluated):
    return lambda text, **arguments: evaluated(text, **arguments)[0]


def echo(*words):
    return "\n".join(f"- executable: {{cmd: 'echo {word}'}}" for word in words)


def words(plan):
    return [process.command[1] for process in plan.processes]


def test_an_argument_has_its_default_unless_it_is_given(plan):
    text = "launch:\n- arg: {name: who, default: world}\n" + echo("$(var who)")
    assert words(plan(text)) == ["world"]
    assert words(plan(text, who="me")) == ["me"]


def test_a_required_argument_that_is_missing_is_named_with_its_description(plan):
    with pytest.raises(
        TeleopctlError,
        match=r"main.yaml:2: Required launch argument 'x' \(description: 'how many'\) was not",
    ):
        plan("launch:\n- arg: {name: x, description: how many}")


def test_an_argument_outside_its_choices_is_refused(plan):
    text = "launch:\n- arg: {name: x, default: a, choice: [{value: a}, {value: b}]}\n"
    assert plan(text, x="b")
    with pytest.raises(TeleopctlError, match=r"Valid options are: \['a', 'b'\]"):
        plan(text, x="c")


def test_an_argument_that_nobody_declares_is_warned_about(plan):
    (warning,) = plan("launch:\n- arg: {name: x, default: a}", y="1").warnings
    assert "'y'" in warning
    assert "x" in warning


@pytest.mark.parametrize(
    ("condition", "runs"),
    [
        ("true", True),
        ("1", True),
        ("True", True),
        ("false", False),
        ("0", False),
        ("$(eval 1 > 2)", False),
    ],
)
def test_conditions_decide(plan, condition, runs):
    for key, expected in (("if", runs), ("unless", not runs)):
        text = f"launch:\n- executable: {{cmd: 'echo a', {key}: '{condition}'}}"
        assert bool(plan(text).processes) is expected


def test_a_condition_that_is_neither_is_an_error(plan):
    with pytest.raises(
        TeleopctlError, match=r"main.yaml:2: expected true, 1, false or 0, got 'maybe'"
    ):
        plan("launch:\n- executable: {cmd: 'echo a', if: maybe}")


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (
            "executable: {cmd: 'echo a', if: $(var x)}",
            "main.yaml:3: launch argument 'x': expected true, 1, false or 0, got 'maybe'",
        ),
        (
            "executable: {cmd: 'echo a', respawn: \"$(var 'x')\"}",
            "main.yaml:3: 'respawn': launch argument 'x': expected true or false, got",
        ),
        (
            "node: {pkg: camera, exec: camera, param: [{name: p, value: $(var x), type: bool}]}",
            "main.yaml:3: parameter 'p': launch argument 'x': expected true or false, got 'maybe'",
        ),
        (
            "node: {pkg: camera, exec: camera, param: [{name: p, value: $(var x), type: float}]}",
            "main.yaml:3: parameter 'p': launch argument 'x': expected a number, got 'maybe'",
        ),
        (
            "group: [let: {name: y, value: $(var x)}, log: {message: a, unless: $(var y)}]",
            "main.yaml:3: launch configuration 'y': expected true, 1, false or 0, got 'maybe'",
        ),
    ],
)
def test_a_launch_argument_that_cannot_be_meant_is_named(plan, step, message):
    with pytest.raises(TeleopctlError, match=re.escape(message)):
        plan(f"launch:\n- arg: {{name: x, default: 'false'}}\n- {step}", x="maybe")


def test_a_group_keeps_its_settings_to_itself_unless_it_is_not_scoped(plan):
    text = """launch:
- let: {name: a, value: outer}
- group:
    scoped: %s
    children:
    - let: {name: a, value: inner}
    - set_env: {name: A_VARIABLE, value: x}
    - executable: {cmd: "echo $(var a) $(env A_VARIABLE)"}
- executable: {cmd: "echo $(var a) $(env A_VARIABLE none)"}
"""
    scoped = plan(text % "true").processes
    assert [process.command[1:] for process in scoped] == [["inner", "x"], ["outer", "none"]]
    assert [process.environment for process in scoped] == [{"A_VARIABLE": "x"}, {}]
    assert plan(text % "false").processes[1].command[1:] == ["inner", "x"]


def test_the_environment_can_be_set_extended_and_cleared(plan, monkeypatch):
    monkeypatch.setenv("A_PATH", "one")
    processes = plan(
        """launch:
- append_env: {name: A_PATH, value: two}
- unset_env: {name: OTHER}
- executable: {cmd: "echo a", env: [{name: OWN, value: 3}]}
"""
    ).processes
    assert processes[0].environment == {"A_PATH": f"one{os.pathsep}two", "OTHER": None, "OWN": "3"}


def test_an_included_file_gets_arguments_and_its_own_folder(plan, tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "inner.yaml").write_text(
        "launch:\n- arg: {name: x}\n" + echo("$(var x)", "$(dirname)")
    )
    text = """launch:
- include: {file: $(dirname)/below/inner.yaml, arg: [{name: x, value: given}]}
""" + echo("$(dirname)")
    assert words(plan(text)) == ["given", str(tmp_path / "below"), str(tmp_path)]


def test_an_error_in_an_included_file_names_the_place_in_that_file(plan, tmp_path):
    (tmp_path / "inner.yaml").write_text("launch:\n- arg: {name: x}")
    with pytest.raises(TeleopctlError, match=r"inner.yaml:2: Required"):
        plan("launch:\n- include: {file: inner.yaml}")


@pytest.mark.parametrize("file", ["sim.yaml", "$(find-pkg-share teleopctl)/launch/sim.yaml"])
def test_a_built_in_file_is_included_by_its_name_or_its_path(plan, file):
    text = f"launch:\n- include: {{file: {file}, arg: [{{name: camera, value: 'false'}}]}}"
    assert [process.name for process in plan(text).processes] == [
        "mujoco_sim-1",
        "robot_state_publisher-2",
        "spawner-3",
    ]


def test_a_file_of_ones_own_includes_the_built_in_one_of_the_same_name(tmp_path):
    path = tmp_path / "display.yaml"
    path.write_text("launch:\n- include: {file: display.yaml}")
    assert len(evaluate(parse_file(path), {}, tmp_path / "log")[0].processes) == 2


def test_built_in_files_start_built_in_programs_whatever_the_folder_holds(
    plan, tmp_path, monkeypatch
):
    package = tmp_path / "ws" / "controller_manager"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>controller_manager</name></package>")
    (package / "setup.py").write_text(
        "setup(entry_points={'console_scripts': ['spawner = gone.spawner:main']})"
    )
    monkeypatch.chdir(tmp_path / "ws")
    own = "- node: {pkg: controller_manager, exec: spawner, args: a}"
    processes = plan(f"launch:\n{own}\n- include: {{file: spawn_controllers.yaml}}").processes
    commands = [process.command[3:7] for process in processes]
    assert commands == [
        ["teleopctl.nodes", "controller_manager", "spawner", "a"],
        ["teleopctl.nodes", "--builtin", "controller_manager", "spawner"],
    ]


@pytest.mark.parametrize("rate", ["0", "-1", "1000000", "1e6", "fast", "true"])
def test_an_update_rate_that_is_none_is_refused_with_its_line(plan, tmp_path, rate):
    mine = tmp_path / "mine.yaml"
    mine.write_text(f"controller_manager:\n  ros__parameters:\n    update_rate: {rate}\n")
    place = re.escape(f"{mine}:3")
    expected = rf"^{place}: Parameter 'update_rate' of /controller_manager is .*65535"
    value = f"$(file-update-rate {mine} controller_manager)"
    with pytest.raises(TeleopctlError, match=expected):
        plan(f'launch:\n- let: {{name: rate, value: "{value}"}}')


def test_the_controllers_to_start_are_those_that_the_file_configures(plan, tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        "/**:\n"
        "  ros__parameters: {type: of/NoController}\n"
        "controller_manager:\n"
        "  ros__parameters:\n"
        "    update_rate: 50\n"
        "    wrist: {type: forward_command_controller/ForwardCommandController}\n"
        "    states: {type: joint_state_broadcaster/JointStateBroadcaster}\n"
        "# As in ros2_control's demos, the type in a section of the controller's own.\n"
        "hand:\n"
        "  ros__parameters:\n"
        "    type: forward_command_controller/ForwardCommandController\n"
        "wrist:\n"
        "  ros__parameters: {joints: [wrist]}\n"
    )
    text = "launch:\n- include: {file: spawn_controllers.yaml}"
    (spawner,) = plan(text, controllers_file=str(mine)).processes
    assert spawner.command[6:9] == ["spawner", "states wrist hand", "--param-file"]
    arm = "arm: {ros__parameters: {type: joint_trajectory_controller/JointTrajectoryController}}"
    mine.write_text(f"{mine.read_text()}\n{arm}\n")
    (spawner,) = plan(text, controllers_file=str(mine)).processes
    # Forward command controllers start last: a trajectory controller claims joints before them.
    assert spawner.command[7] == "states arm wrist hand"
    assert "--keep-going" in spawner.command
    (spawner,) = plan(text, controllers_file=str(mine), controllers="wrist").processes
    assert "--keep-going" not in spawner.command
    mine.write_text("controller_manager: {ros__parameters: {update_rate: 50}}")
    with pytest.raises(TeleopctlError, match=r"mine\.yaml configures no controllers"):
        plan(text, controllers_file=str(mine))
    missing = tmp_path / "missing.yaml"
    with pytest.raises(TeleopctlError, match=f"^Cannot read {re.escape(str(missing))}: "):
        plan(text, controllers_file=str(missing))


def test_a_file_that_includes_itself_is_an_error(plan):
    with pytest.raises(TeleopctlError, match="levels deep"):
        plan("launch:\n- include: {file: main.yaml}")


def test_a_node_becomes_a_command_line_with_ros_arguments(plan, tmp_path):
    given = tmp_path / "given.yaml"
    given.write_text("/**: {ros__parameters: {a: 1}}")
    result = plan(
        f"""launch:
- push_ros_namespace: {{namespace: fleet}}
- set_parameter: {{name: use_sim_time, value: true}}
- set_remap: {{from: a, to: b}}
- node:
    pkg: teleop_py_pkg
    exec: simple_publisher
    name: talker
    namespace: robot
    args: --loud 'two words'
    ros_args: --log-level debug
    output: screen
    remap:
    - {{from: chatter, to: /said}}
    param:
    - {{name: rate, value: 2.5}}
    - {{name: text, value: "24", type: str}}
    - {{name: quoted, value: '24'}}
    - {{name: quoted_list, value: ['1', "true"]}}
    - {{name: demanded, value: '24', type: int}}
    - {{name: list, value: [1, 2]}}
    - name: nested
      param:
      - {{name: inner, value: "$(eval 1 + 1)"}}
    - {{from: {given}}}
    - {{name: last, value: 1}}
"""
    )
    (process,) = result.processes
    first, second = result.start.files
    assert process.name == "simple_publisher-1"
    assert process.node_name == "/fleet/robot/talker"
    assert process.stdout.screen
    assert process.command == [
        *[sys.executable, "-P", "-m", "teleopctl.nodes", "teleop_py_pkg", "simple_publisher"],
        *["--loud", "two words", "--ros-args", "--log-level", "debug"],
        *["-r", "__node:=talker", "-r", "__ns:=/fleet/robot"],
        *["--params-file", first, "--params-file", str(given), "--params-file", second],
        *["-r", "a:=b", "-r", "chatter:=/said"],
    ]
    assert yaml.safe_load(result.start.files[first]) == {
        "/**": {
            "ros__parameters": {
                "use_sim_time": True,
                "rate": 2.5,
                "text": "24",
                "quoted": "24",
                "quoted_list": ["1", "true"],
                "demanded": 24,
                "list": [1, 2],
                "nested.inner": 2,
            }
        }
    }


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ("pkg: nope, exec: x", "main.yaml:2: Package 'nope' not found"),
        ("pkg: camera, exec: x", "main.yaml:2: No executable found"),
        (
            "pkg: camera, exec: camera, output: loud",
            "expected one of .*full, got 'loud'",
        ),
        ("pkg: camera, exec: camera, respawn: maybe", "'respawn': expected true or false"),
        ("pkg: camera, exec: camera, respawn_delay: long", "'respawn_delay': expected a number"),
        (
            "pkg: camera, exec: camera, name: $(var who)",
            "launch configuration 'who' does not exist",
        ),
        ("pkg: camera, exec: camera, name: $(vra who)", "unknown substitution 'vra'"),
        ("pkg: camera, exec: camera, name: $(var)", "expected 1 to 2 argument"),
        ("pkg: camera, exec: camera, name: $(eval 1 +)", "is not an expression"),
        ('pkg: camera, exec: camera, args: "\'"', "'args': No closing quotation"),
        ('pkg: camera, exec: camera, name: $(command "echo \'")', "No closing quotation"),
        ("pkg: camera, exec: camera, sigterm_timeout: .inf", "'sigterm_timeout': expected a num"),
        ("pkg: camera, exec: camera, respawn_max_retries: .inf", "expected an integer, got 'inf'"),
    ],
)
def test_what_cannot_be_evaluated_is_an_error_before_anything_starts(plan, node, message):
    with pytest.raises(TeleopctlError, match=message):
        plan(f"launch:\n- node: {{{node}}}")


def test_a_command_sees_the_environment_that_the_file_sets_and_may_write_any_bytes(plan, tmp_path):
    script = tmp_path / "says.py"
    script.write_text(
        "import os, sys\nsys.stdout.buffer.write(os.environ['WHO'].encode() + bytes([255]))\n"
    )
    text = f"""launch:
- set_env: {{name: WHO, value: me}}
- executable: {{cmd: "echo $(command '{sys.executable} {script}')"}}
"""
    assert words(plan(text)) == ["me\ufffd"]


def test_prefixes_and_shells(plan):
    text = """launch:
- executable: {cmd: "echo a", launch-prefix: nice -n 5}
- executable: {cmd: "echo $HOME | cat", shell: true}
"""
    first, second = plan(text).processes
    assert first.command == ["nice", "-n", "5", "echo", "a"]
    assert second.command == ["echo $HOME | cat"]
    assert second.name == "echo-2"
    assert plan("launch:\n" + echo("a"), prefix="time -p").processes[0].command[:2] == [
        "time",
        "-p",
    ]


def test_a_prefix_stands_before_the_programs_that_its_filter_fits(plan):
    text = "launch:\n- node: {pkg: camera, exec: camera}\n" + echo("a")
    first, second = plan(text, prefix="time", prefix_filter="cam.*").processes
    assert first.command[0] == "time"
    assert second.command[0] == "echo"


def test_what_is_found_nowhere_can_be_left_out(plan):
    text = "launch:\n- node: {pkg: nowhere, exec: x}\n" + echo("a")
    result = plan(text, skip_missing=True)
    assert words(result) == ["a"]
    ((level, _, message),) = result.start.messages
    assert level == "WARNING"
    assert re.fullmatch(r"left out: .*main\.yaml:2: Package 'nowhere' not found", message)


def test_what_stands_in_a_timer_is_evaluated_when_its_time_has_come(evaluated):
    plan, evaluation = evaluated(
        "launch:\n- let: {name: x, value: before}\n"
        "- timer: {period: 1.5, children: [{executable: {cmd: echo $(var x)}}]}\n"
        "- let: {name: x, value: behind}\n" + echo("b")
    )
    assert words(plan) == ["b"]
    ((seconds, timer),) = plan.start.timers
    assert seconds == 1.5
    (process,) = evaluation.handle_timer(timer).processes
    assert (process.name, process.command) == ("echo-2", ["echo", "before"])


def test_what_is_missing_in_a_timer_is_told_before_anything_starts(plan):
    node = "{node: {pkg: camera, exec: camra}}"
    with pytest.raises(TeleopctlError, match=r"main\.yaml:2: No executable found"):
        plan(f"launch:\n- timer: {{period: 9, children: [{node}]}}")


def test_log_lines_are_kept_in_order(plan):
    text = "launch:\n- log: {message: one}\n- log: {message: two, level: warn}"
    assert plan(text).start.messages == [
        ("INFO", "launch.user", "one"),
        ("WARNING", "launch.user", "two"),
    ]


def test_shutdown_ends_the_launch_with_its_reason_before_anything_starts(plan):
    text = "launch:\n- shutdown: {reason: not $(var what), if: $(var wanted)}\n" + echo("a")
    assert words(plan(text, what="now", wanted="false")) == ["a"]
    with pytest.raises(TeleopctlError, match=r"^not now$"):
        plan(text, what="now", wanted="true")


def test_a_shutdown_in_a_timer_waits_for_it(evaluated):
    plan, evaluation = evaluated(
        "launch:\n- timer: {period: 1, children: [{shutdown: {reason: late}}]}\n" + echo("a")
    )
    assert words(plan) == ["a"]
    ((_, timer),) = plan.start.timers
    assert evaluation.handle_timer(timer).shutdown == "late"


def test_the_logical_substitutions(plan):
    text = "launch:\n" + echo(
        "$(not true)",
        "$(and true 1)",
        "$(or false 0)",
        "$(equals a a)",
        "$(not-equals a a)",
        "$(if true yes no)",
        "$(any false true)",
        "$(all true false)",
    )
    assert words(plan(text)) == ["false", "true", "false", "true", "false", "yes", "true", "false"]


def test_commands_give_their_output_or_the_reason_of_their_failure(plan):
    assert words(plan("launch:\n" + echo('$(command "echo hello")'))) == ["hello\n"]
    with pytest.raises(TeleopctlError, match="executed command failed"):
        plan("launch:\n" + echo("$(command false)"))
    with pytest.raises(TeleopctlError, match="nosuchprogram"):
        plan("launch:\n" + echo("$(command nosuchprogram)"))


def test_a_robot_description_is_expanded_once_for_all_nodes(plan, tmp_path, monkeypatch):
    from teleopctl import robot

    calls = []

    def read_model(path, mappings):
        calls.append((path, mappings))
        return robot.ExpandedXacro(ARM, (path,))

    monkeypatch.setattr(robot, "read_model", read_model)
    node = (
        "- node: {pkg: camera, exec: camera, param: "
        "[{name: robot_description, value: \"$(xacro 'my arm.xacro' speed:=2)\"}]}\n"
    )
    result = plan("launch:\n" + node + node)
    assert [mappings for _, mappings in calls] == [{"speed": "2"}]
    assert all("<robot" in text for text in result.start.files.values())


def test_a_description_that_is_no_robot_is_an_error_before_anything_starts(plan, tmp_path):
    arm = tmp_path / "arm.urdf"
    arm.write_text('<robot name="x"><link name="a"/><link name="b"/></robot>')
    with pytest.raises(TeleopctlError) as raised:
        plan("launch:\n" + echo(f"$(xacro {arm})"))
    assert raised.value.message == f"{arm}: Two root links found: [a] and [b]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "Cannot read {arm}: No such file or directory"),
        ("<robot", "{arm}:1:1: invalid XML: unclosed token"),
    ],
)
def test_a_mistake_in_a_description_names_the_description_and_not_the_launch_file(
    plan, tmp_path, text, message
):
    arm = tmp_path / "arm.urdf"
    if text is not None:
        arm.write_text(text)
    node = (
        "- node: {pkg: robot_state_publisher, exec: robot_state_publisher, param: "
        f"[{{name: robot_description, value: $(xacro {arm})}}]}}"
    )
    with pytest.raises(TeleopctlError) as raised:
        plan(f"launch:\n{node}")
    assert raised.value.message == message.format(arm=arm)


def test_a_world_file_is_its_path_and_no_world_is_empty(plan, tmp_path):
    world = tmp_path / "world.urdf"
    world.write_text(ARM)
    assert words(plan("launch:\n" + echo(f"$(world-file {world})"))) == [str(world)]
    assert words(plan("launch:\n" + echo('<$(world-file "")>'))) == ["<>"]


def test_a_mistake_in_a_world_names_the_world_and_not_the_launch_file(plan, tmp_path):
    world = tmp_path / "world.urdf"
    world.write_text("<robot>\n<link/></robot>")
    with pytest.raises(TeleopctlError) as raised:
        plan("launch:\n" + echo(f"$(world-file {world})"))
    assert raised.value.message.startswith(f"{world}: ")


def test_a_semantic_description_is_no_robot_that_lacks_links(plan, tmp_path):
    srdf = tmp_path / "arm.srdf.xacro"
    srdf.write_text('<robot name="arm"><group name="all"><link name="base"/></group></robot>')
    ((_, word),) = [one.command for one in plan("launch:\n" + echo(f"$(xacro {srdf})")).processes]
    assert '<group name="all">' in word


def test_the_command_that_every_ros_launch_file_uses_needs_no_xacro_on_the_path(plan, monkeypatch):
    from teleopctl import robot

    monkeypatch.setattr(
        robot,
        "read_model",
        lambda path, given: robot.ExpandedXacro(f"{path.name} {given}", (path,)),
    )
    monkeypatch.setenv("PATH", "")
    for program in ("xacro", "$(find-exec xacro)"):
        for line in ("a.xacro b:=1 c:=", "b:=1 a.xacro c:="):
            command = f'$(command "{program} {line}")'
            assert words(plan("launch:\n" + echo(command))) == ["a.xacro {'b': '1', 'c': ''}"]
    for line, error in (("a.xacro more", "expected 'name:=value', got 'more'"), ("", "missing")):
        with pytest.raises(TeleopctlError, match=error):
            plan(f"launch:\n- executable: {{cmd: echo $(command 'xacro {line}')}}")


def test_a_request_survives_the_way_to_another_process(tmp_path):
    request = LaunchRequest(file="/hé.yaml", arguments={"x": "1"}, prefix="nice")
    request.save(tmp_path / "request.json")
    assert load_request(tmp_path / "request.json") == request


@pytest.mark.parametrize("value", ["[[1, 2]]", "99999999999999999999", "[1, 99999999999999999999]"])
def test_a_value_that_no_parameter_can_have_is_refused_with_its_line(tmp_path, value):
    path = tmp_path / "file.launch.yaml"
    node = "pkg: demo_nodes_py, exec: talker"
    path.write_text(f"launch:\n- node: {{{node}, param: [{{name: x, value: {value}}}]}}\n")
    with pytest.raises(TeleopctlError, match="cannot be its value") as refused:
        evaluate(parse_file(path), {}, tmp_path / "log")
    assert refused.value.message.startswith(f"{path}:2: parameter 'x': ")
