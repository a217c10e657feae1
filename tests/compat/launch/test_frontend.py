"""``launch.frontend.Parser``: what stands in a text as the actions of a Python launch file."""

import io
import os
from pathlib import Path
from unittest import mock

import pytest
from launch import InvalidLaunchFileError, LaunchContext, LaunchDescription
from launch._entities import steps
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    SetLaunchConfiguration,
    Shutdown,
    TimerAction,
)
from launch.frontend import Parser, expose_action
from launch.frontend.known import ReadStep, action_of
from launch.launch_description_sources import FrontendLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, SetParameter

from teleopctl.launch import Evaluation, parse_text, read_step

ENTRIES = """<launch>
<let name="a" value="1"/>
<let name="b" value="$(var a)2" if="$(equals $(var a) 1)"/>
<let name="never" value="x" unless="true"/>
<arg name="given" default="$(var b)" description="what" ><choice value="12"/></arg>
<bool_arg name="flag" default="true"/>
<set_env name="E_ONE" value="$(var a)"/>
<append_env name="E_ONE" value="0" prepend="yes" separator="-"/>
<append_env name="E_TWO" value="$(env E_ONE)"/>
<unset_env name="E_GONE"/>
<group scoped="false"><let name="in" value="group"/></group>
<group forwarding="false">
  <keep name="kept" value="$(var a)"/>
  <executable cmd="echo '$(var kept)' $(env E_ONE none)"/>
</group>
<group><reset_env/><executable cmd="echo" name="reset"/></group>
<group><rep_env><env name="PATH" value="/bin"/></rep_env><executable cmd="echo"/></group>
<group><reset><keep name="a" value="$(var b)"/></reset><log_info message="$(var a)"/></group>
<log message="hello $(var b)"/>
<log level="WARN" message="careful"/>
<log level="$(var level DEBUG)" message="hidden"/>
<log_error message="bad"/>
<push_ros_namespace namespace="ns"/>
<set_remap from="x" to="$(var a)"/>
<set_parameter name="p" value="$(var b)"/>
<set_parameter name="q" value="1 2" value-sep=" " type="list_of_str"/>
<set_use_sim_time value="false"/>
<set_ros_log_dir new_log_dir="below"/>
<executable cmd="ls -l 'a b' $(var a)" cwd="/" name="own" output="both" sigterm_timeout="2"
  sigkill_timeout="$(var a)" respawn="true" respawn_delay="0.5" emulate_tty="1" shell="false"
  launch-prefix="nice -n 5"><env name="E_OWN" value="$(var b)"/></executable>
<node pkg="camera" exec="camera" name="n" namespace="inner" args="-a '$(var a) b'"
  ros_args="--log-level info" exec_name="program" output="screen">
  <param name="i" value="5"/><param name="f" value="0.5"/><param name="s" value="'5'"/>
  <param name="t" value="$(var b)" type="str"/><param name="v" value="$(var b)"/>
  <param name="list" value="1, 2" value-sep=", "/>
  <param name="outer"><param name="in" value="true"/></param>
  <remap from="from" to="to"/>
</node>
<node exec="camera" on_exit="shutdown"/>
<timer period="5"><log message="later $(var a)"/></timer>
<ros_timer period="$(var a)"><log message="later"/></ros_timer>
<for_each values="{x: 1}; {x: 2}"><let name="e$(for-var x)" value="each"/></for_each>
<shutdown reason="enough"/>
</launch>"""


def entries():
    _, root = parse_text(ENTRIES, Path("file.launch.xml"), "xml")
    children = root.fields(("children",))["children"]
    return [read_step(*item.action()) for item in children.items("actions")]


def leaves_behind(actions):
    """What entries do to a launch, and what they give it to do."""
    context = LaunchContext()
    launch: Evaluation = context.launch
    launch.run(actions)
    further = launch.take_follow_up()
    later = []
    for seconds, timer in further.timers:
        messages = launch.handle_timer(timer).messages
        later.append((seconds, messages))
    environment = {name: value for name, value in os.environ.items() if name[:2] in ("E_", "RO")}
    told = further.processes, further.files, further.messages, further.shutdown, later
    return dict(context.launch_configurations), environment, told


def test_entries_read_as_actions_of_python_do_what_the_entries_do():
    with mock.patch.dict(os.environ):
        expected = leaves_behind(tuple(entries()))
    with mock.patch.dict(os.environ):
        made = [action_of(step) for step in entries()]
        assert [type(each) for each in made if isinstance(each, ReadStep)] == [ReadStep]
        found = leaves_behind(steps(made))
    # There an action ends the launch that asks for it when the process has ended.
    assert described(found) == described(expected)


def described(left):
    variables, environment, (processes, *others) = left
    plans = [repr(plan).replace("on_exit=True", "on_exit=False") for plan in processes]
    return variables, environment, plans, others


YAML = """
launch:
- arg: {name: who, default: me, description: whom it greets}
- group:
  - let: {name: a, value: $(var who)}
  - executable: {cmd: "echo '$(var who) b'", shell: true, on_exit: shutdown, output: log}
- timer: {period: 2.5, children: [{include: {file: other.yaml, arg: [{name: x, value: $(var a)}]}}]}
- node: {pkg: camera, exec: camera, if: $(var who), remap: [{from: a, to: b}]}
- set_parameter: {name: p, value: [1, 2]}
"""


def test_a_program_finds_actions_with_their_properties():
    entity, parser = Parser.load(io.StringIO(YAML))
    description = parser.parse_description(entity)
    argument, group, timer, node, parameter = description.entities
    assert isinstance(argument, DeclareLaunchArgument)
    assert (argument.name, argument.description) == ("who", "whom it greets")
    assert isinstance(group, GroupAction)
    _, _, let, executable, *_ = group.get_sub_entities()
    assert isinstance(let, SetLaunchConfiguration)
    assert isinstance(let.value[0], LaunchConfiguration)
    assert isinstance(executable, ExecuteProcess)
    assert executable.shell is True
    assert isinstance(executable.get_sub_entities()[0], Shutdown)
    assert isinstance(timer, TimerAction)
    assert timer.period == 2.5
    assert isinstance(timer.actions[0], IncludeLaunchDescription)
    assert isinstance(node, Node)
    assert node.condition is not None
    assert isinstance(parameter, SetParameter)
    assert list(description.get_launch_arguments()) == [argument]


@pytest.mark.parametrize(
    "text",
    ["<launch><arg name='a' misspelt='b'/></launch>", "launch: [arg: {name: a, misspelt: b}]"],
)
def test_what_does_not_belong_is_named(text):
    entity, parser = Parser.load(io.StringIO(text))
    with pytest.raises(ValueError, match=r"`arg`.*misspelt"):
        parser.parse_description(entity)


def test_what_is_no_launch_file_is_refused_in_every_language(tmp_path):
    path = tmp_path / "x.xml"
    path.write_text("<launch")
    with pytest.raises(InvalidLaunchFileError, match="xml"):
        Parser.load(path)
    assert Parser.is_filename_valid("a.launch.yaml")
    assert not Parser.is_filename_valid("a.launch.py")
    assert Parser.get_file_extensions_from_parsers() == {"xml", "yaml", "yml"}


def test_a_text_that_is_included_tells_its_arguments(tmp_path):
    path = tmp_path / "inner.launch.xml"
    path.write_text("<launch><arg name='wanted' description='it'/></launch>")
    include = IncludeLaunchDescription(FrontendLaunchDescriptionSource(str(path)))
    (argument,) = LaunchDescription([include]).get_launch_arguments()
    assert (argument.name, argument.description) == ("wanted", "it")


@expose_action("loud_node")
class LoudNode(Node):
    """A node whose entry has a key of its own beside those of ``node``."""

    @classmethod
    def parse(cls, entity, parser, ignore=None):
        _, words = super().parse(entity, parser, ignore=["name"])
        words["name"] = entity.get_attr("called").upper()
        return cls, words


def test_a_class_of_ones_own_reads_the_keys_of_its_base_by_it():
    attributes = "pkg='camera' exec='camera' called='me' if='true' namespace='a'"
    xml = f"<launch><loud_node {attributes}/></launch>"
    entity, parser = Parser.load(io.StringIO(xml))
    (node,) = parser.parse_description(entity).entities
    assert isinstance(node, LoudNode)
    node.visit(LaunchContext())
    assert node.node_name == "/a/ME"
    assert node.expanded_node_namespace == "/a"
