"""What the actions and substitutions of ROS 2's XML and YAML launch files do."""

import os
from itertools import pairwise
from pathlib import Path

import pytest
import yaml

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file

NODE = '<node pkg="camera" exec="camera"/>'


@pytest.fixture
def plan(tmp_path):
    def plan(text, **arguments):
        path = tmp_path / "main.launch.xml"
        path.write_text(f"<launch>\n{text}\n</launch>", encoding="utf-8")
        return evaluate(read_launch_file(path), arguments, tmp_path / "log")[0]

    return plan


@pytest.fixture
def value(plan):
    """The text that a text with substitutions stands for, after some actions."""

    def value(text, before=""):
        return said(plan(f'{before}<log message="{text}"/>'))[-1]

    return value


def said(plan):
    """The texts of what is said."""
    return [text for _, _, text in plan.start.messages]


def parameters(plan):
    """The parameters of each node, by the order of the nodes."""
    return [
        yaml.safe_load(text)["/**"]["ros__parameters"]
        for _, text in sorted(plan.start.files.items())
    ]


def test_a_group_that_forwards_nothing_begins_with_what_it_keeps(plan, monkeypatch):
    monkeypatch.setenv("OUTER", "shell")
    evaluated = plan(
        """
        <let name="x" value="outer"/>
        <let name="y" value="other"/>
        <set_env name="SET" value="1"/>
        <push_ros_namespace namespace="robot"/>
        <set_parameter name="p" value="1"/>
        <set_remap from="a" to="b"/>
        <group forwarding="false">
          <keep name="x" value="$(var x) kept"/>
          <log message="$(var x) $(var y nothing) $(env SET unset) $(env OUTER)"/>
        """
        + NODE
        + """
        </group>
        <log message="$(var x) $(var y) $(env SET)"/>
        """
    )
    assert said(evaluated) == [
        "outer kept nothing unset shell",
        "outer other 1",
    ]
    assert "--ros-args" not in evaluated.processes[0].command
    assert evaluated.processes[0].environment == {}


@pytest.mark.parametrize(
    ("scoped", "after"), [("true", "outer"), ("false", "kept"), ("1", "outer"), ("0", "kept")]
)
def test_what_a_group_keeps_is_set_for_its_actions(value, scoped, after):
    before = '<let name="x" value="outer"/><group scoped="{}"><keep name="x" value="kept"/></group>'
    assert value("$(var x)", before.format(scoped)) == after


def test_reset_forgets_all_but_the_environment_and_what_is_kept(plan):
    evaluated = plan(
        """
        <let name="x" value="1"/>
        <set_env name="SET" value="1"/>
        <push_ros_namespace namespace="robot"/>
        <set_parameter name="p" value="1"/>
        <set_remap from="a" to="b"/>
        <reset><keep name="y" value="was $(var x)"/></reset>
        <log message="$(var x gone) $(var y) $(env SET)"/>
        """
        + NODE
    )
    assert said(evaluated) == ["gone was 1 1"]
    assert "--ros-args" not in evaluated.processes[0].command


@pytest.mark.parametrize(
    ("actions", "expected"),
    [
        ('<append_env name="A" value="b"/>', f"a{os.pathsep}b"),
        ('<append_env name="A" value="b" prepend="true"/>', f"b{os.pathsep}a"),
        ('<append_env name="A" value="b" separator=";"/>', "a;b"),
        ('<append_env name="B" value="b" prepend="true" separator=";"/>', "a"),
        ('<set_env name="A" value="x"/><reset_env/>', "a"),
        ('<unset_env name="A"/><reset_env/>', "a"),
        ('<rep_env><env name="B" value="b"/></rep_env>', "none"),
        ('<rep_env><env name="A" value="$(env A)$(env A)"/></rep_env>', "aa"),
    ],
)
def test_the_environment_of_what_follows(value, monkeypatch, actions, expected):
    monkeypatch.setenv("A", "a")
    monkeypatch.delenv("B", raising=False)
    assert value("$(env A none)", actions) == expected


def test_a_folder_for_logs_lies_in_the_one_before(plan, tmp_path):
    one, two, three = plan(
        f"""
        <set_ros_log_dir new_log_dir="{tmp_path}/logs"/>{NODE}
        <set_ros_log_dir new_log_dir="below"/>{NODE}
        <set_ros_log_dir new_log_dir="{tmp_path}/other"/>{NODE}
        """
    ).processes
    assert one.environment == {"ROS_LOG_DIR": f"{tmp_path}/logs"}
    assert two.environment == {"ROS_LOG_DIR": f"{tmp_path}/logs/below"}
    assert three.environment == {"ROS_LOG_DIR": f"{tmp_path}/other"}


def test_a_boolean_argument_is_true_or_false(plan):
    text = '<bool_arg name="b" default="TRUE"/>'
    assert plan(text, b="false")
    with pytest.raises(TeleopctlError, match="Valid options are: \\['true', 'false', 'True'"):
        plan(text, b="1")


def test_loops_take_their_actions_with_each_value(plan):
    evaluated = plan(
        """
        <let name="robots" value="{name: a, id: 1}; {name: b}"/>
        <for_each values="$(var robots)">
          <for len="2" name="i">
            <log message="$(for-var name) $(for-var id none) $(index i)"/>
          </for>
        </for_each>
        <log message="$(for-var name outside)"/>
        """
    )
    assert said(evaluated) == [
        "a 1 0",
        "a 1 1",
        "b none 0",
        "b none 1",
        "outside",
    ]


def test_a_loop_over_nothing_says_so(plan):
    plan_of_none = plan('<for_each values=""><log message="x"/></for_each>')
    assert said(plan_of_none) == ["no input values: will not iterate"]


def test_a_log_action_has_the_level_of_its_name(plan):
    text = '<log_{0} message="x"/>'
    names = ("debug", "info", "warning", "error")
    levels = [level for level, *_ in plan("".join(map(text.format, names))).start.messages]
    assert levels == ["DEBUG", "INFO", "WARNING", "ERROR"]


def test_a_parameter_for_all_nodes_is_what_it_was_when_it_was_set(plan):
    evaluated = plan(
        """
        <let name="x" value="1"/>
        <set_parameter name="p" value="$(var x)"/>
        <let name="x" value="2"/>
        """
        + NODE
    )
    assert parameters(evaluated) == [{"p": 1}]


def test_a_parameter_file_for_all_nodes_comes_before_a_nodes_own_parameters(plan, tmp_path):
    file = tmp_path / "all.yaml"
    file.touch()
    evaluated = plan(
        f"""
        <set_parameter name="a" value="1"/>
        <set_parameters_from_file filename="{file}"/>
        <node pkg="camera" exec="camera"><param name="b" value="2"/></node>
        """
    )
    command = evaluated.processes[0].command
    files = [word for before, word in pairwise(command) if before == "--params-file"]
    assert files[1] == str(file)
    assert parameters(evaluated) == [{"b": 2}, {"a": 1}]


def test_a_timer_in_ros_time_counts_seconds_unless_time_is_simulated(plan):
    timer = f'<ros_timer period="2">{NODE}</ros_timer>'
    ((seconds, _),) = plan(f'<set_use_sim_time value="false"/>{timer}').start.timers
    assert seconds == 2.0
    simulated = plan(f'<set_use_sim_time value="true"/>{timer}').start
    assert (len(simulated.timers), len(simulated.works)) == (0, 1)
    # It holds for the whole launch: also for a timer before it.
    before = plan(f'<group>{timer}</group><set_use_sim_time value="true"/>').start
    assert (len(before.timers), len(before.works)) == (0, 1)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("$(equals 1 1.0)", "true"),
        ("$(equals 0.3 0.30000000000000004)", "true"),
        ("$(equals True 1)", "true"),
        ("$(equals false 0)", "true"),
        ("$(equals a A)", "false"),
        ("$(not-equals 1e0 1)", "false"),
        ("$(not-equals a b)", "true"),
        ("$(not on)", "false"),
        ("$(and yes true)", "true"),
        ("$(any)", "false"),
        ("$(all)", "true"),
        ("$(if off a b)", "b"),
        ("$(eval 'math.floor(pi)' 'math')", "3"),
        ("$(path-join /a 'b c' d$(var x).yml)", "/a/b c/dx.yml"),
        ("$(path-join /a b '')", "/a/b/"),
        ("$(string-join . https://$(var x) ros org)", "https://x.ros.org"),
        ("$(string-join '' a b)", "ab"),
        ("$(param p)", "1.5"),
        ("$(param flag)", "True"),
        ("$(param nope fallback)", "fallback"),
    ],
)
def test_substitutions(value, text, expected):
    before = """
        <let name="x" value="x"/>
        <set_parameter name="p" value="1.5"/>
        <set_parameter name="flag" value="true"/>
    """
    assert value(text, before).replace(os.sep, "/") == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("$(param nope)", "no set_parameter has set parameter 'nope'"),
        ("$(for-var a)", "no enclosing loop sets 'a'"),
        ("$(file-content nope.txt)", r"File not found: .*nope\.txt"),
        ("$(exec-in-pkg nope camera)", "No executable found"),
        ("$(eval '1' 'os')", "module 'os' is not available, only math"),
        ("$(not maybe)", "expected true or false, got 'maybe'"),
    ],
)
def test_a_substitution_that_cannot_be_made_is_told_with_file_and_line(plan, text, message):
    with pytest.raises(TeleopctlError, match=rf"main\.launch\.xml:2: .*{message}"):
        plan(f'<log message="{text}"/>')


def test_the_files_and_programs_of_a_package(value, tmp_path, monkeypatch):
    folder = tmp_path / "packages" / "arm"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    (folder / "note.txt").write_text("a note")
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(folder.parent))
    assert value("$(file-content $(find-pkg-share arm)/note.txt)") == "a note"
    assert value("$(file-content $(find-pkg-prefix arm)/share/arm/note.txt)") == "a note"
    assert Path(value("$(exec-in-pkg camera camera)")).is_file()


def test_what_a_substitution_gives_is_a_part_of_one_word_of_a_command_line(plan):
    evaluated = plan(
        """
        <let name="x" value="my 'file"/>
        <let name="none" value=""/>
        <executable cmd="echo  $(var x) a$(var x)b '-f $(var x)' $(var x)$(var x) $(var none)"/>
        <node pkg="camera" exec="camera" args="$(var x) two" ros_args="--remap a:=$(var x)"/>
        <executable cmd="echo '$(var x)" shell="true" args="$(var none) a"/>
        """
    )
    x = "my 'file"
    echo, camera, shell = (process.command for process in evaluated.processes)
    assert echo == ["echo", x, f"a{x}b", f"-f {x}", x + x, ""]
    assert camera[camera.index("camera") + 2 :] == [x, "two", "--ros-args", "--remap", f"a:={x}"]
    assert shell == [f"echo '{x}  a"]


def test_an_open_quotation_is_refused_before_anything_starts(plan):
    with pytest.raises(TeleopctlError, match=r":2: 'args': No closing quotation"):
        plan('<node pkg="camera" exec="camera" args="it\'s"/>')


def test_a_node_of_no_package_is_a_command(plan):
    text = '<node exec="my_program" name="me" args="-v"><param name="p" value="1"/></node>'
    (process,) = plan(text).processes
    assert process.command[:5] == ["my_program", "-v", "--ros-args", "-r", "__node:=me"]
    assert process.is_node
    assert process.name == "my_program-1"


def test_a_parameter_file_may_have_substitutions(plan, tmp_path):
    file = tmp_path / "p.yaml"
    file.write_text("/**: {ros__parameters: {p: $(var x), q: '$(dirname)'}}")
    node = '<node pkg="camera" exec="camera"><param from="{}" allow_substs="{}"/></node>'
    evaluated = plan('<let name="x" value="1"/>' + node.format(file, "true"))
    assert parameters(evaluated) == [{"p": 1, "q": str(tmp_path)}]
    assert not plan(node.format(file, "$(not true)")).start.files
    with pytest.raises(TeleopctlError, match="launch configuration 'x' does not exist"):
        plan(node.format(file, "1"))
    file.write_text("a: $(env NOT_SET ']')")
    with pytest.raises(TeleopctlError, match=r"parameter file .*p\.yaml: "):
        plan(node.format(file, "true"))


@pytest.mark.parametrize(
    "attributes", ["from='a' name='b'", "name='a' allow_substs='true'", "from='a' value='1'"]
)
def test_a_parameter_is_a_file_or_a_value(plan, attributes):
    with pytest.raises(TeleopctlError, match="exclude each other"):
        plan(f'<node pkg="camera" exec="camera"><param {attributes}/></node>')
