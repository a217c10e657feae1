"""XML launch files: what the tags mean, and where and why a file is refused."""

from typing import Any

import pytest
import yaml
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "file.launch.xml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def plan(write, tmp_path):
    def plan(text, **arguments):
        file = read_launch_file(write(f"<launch>{text}</launch>"))
        return evaluate(file, arguments, tmp_path / "log")[0]

    return plan


@pytest.fixture
def parameter(plan):
    """The value of the one parameter of a node, from the attributes of its tag."""

    def parameter(attributes):
        node = '<node pkg="camera" exec="camera"><param name="p" {}/></node>'
        (content,) = plan(node.format(attributes)).start.files.values()
        return yaml.safe_load(content)["/**"]["ros__parameters"]["p"]

    return parameter


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("", 1, "not XML: no element found"),
        ("<launch>\n<node</launch>", 2, "not XML: not well-formed"),
        ("<launch>\n</lunch>", 2, "not XML: mismatched tag"),
        ("<robot/>", 1, "expected <launch> as the outermost tag, got <robot>"),
        ("<launch>\n<nod/>\n</launch>", 2, "unknown action 'nod', expected one of"),
        (
            "<launch>\n<node\n  pkg='a'\n  exec='b'\n  outptu='screen'\n/>\n</launch>",
            5,
            "'node.outptu': unknown attribute 'outptu', expected one of",
        ),
        (
            "<launch>\n<node pkg='a' exec='b'>\n<parm/></node></launch>",
            3,
            "'node.parm': unknown tag 'parm', expected one of",
        ),
        ("<launch>\n<node pkg='a'/></launch>", 2, "'node': 'exec' is missing"),
        ("<launch>\n<node pkg='a' exec='b' remap='c'/></launch>", 2, "expected tags <remap>"),
        ("<launch>\n<let value='a'><name/></let></launch>", 2, "expected a text, got a tag <name>"),
        ("<launch>\n<let name='a' value='$(var x'/></launch>", 2, "has no closing '\\)'"),
        ("<launch>\n<group scoped='maybe'/></launch>", 2, "expected true or false, got 'maybe'"),
        ("<launch>\n<let name='a' value='b' value-sep=''/></launch>", 2, "between the items"),
        ("<launch>\n<let name='a;b' name-sep=';' value=''/></launch>", 2, "got a list of 2"),
        ("<launch>\n<node_container/></launch>", 2, "'name' is missing"),
        ("<launch>\n<node pkg='a' exec='b' on_exit='explode'/></launch>", 2, "expected 'shutdown'"),
        (
            "<!DOCTYPE launch [\n<!ENTITY a SYSTEM '/etc/passwd'>]>\n<launch>&a;</launch>",
            2,
            "an entity, 'a', is not read",
        ),
        ("<launch>\n" + "<group>" * 60 + "</group>" * 60 + "</launch>", 2, "nested too deeply"),
    ],
)
def test_errors_name_file_line_and_what_was_expected(write, text, line, expected):
    path = write(text)
    with pytest.raises(TeleopctlError, match=expected) as caught:
        read_launch_file(path)
    assert caught.value.message.startswith(f"{path}:{line}:")


def test_a_misspelled_attribute_has_a_suggestion(write):
    with pytest.raises(TeleopctlError) as caught:
        read_launch_file(write("<launch><node pkg='a' exec='b' namspace='c'/></launch>"))
    assert caught.value.hint == "Did you mean namespace or name?"


def test_an_old_spelling_has_the_present_one_as_a_hint(write):
    with pytest.raises(TeleopctlError, match="unknown attribute 'node-name'") as caught:
        read_launch_file(write("<launch><node pkg='a' exec='b' node-name='c'/></launch>"))
    assert caught.value.hint == "In ROS 2: 'name'."


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("<node pkg='a' type='b' name='c'/>", "<node type=…> is <node exec=…> in ROS 2"),
        (
            "<param name='m' value='$(find arm)/x.urdf'/>",
            "<param> outside of a node is <set_parameter name=… value=…/>",
        ),
        ("<let name='a' value='$(find arm)'/>", r"\$\(find arm\) is \$\(find-pkg-share arm\)"),
        ("<let name='a' value='b$(arg sim)'/>", r"\$\(arg sim\) is \$\(var sim\) in ROS 2"),
        ("<test test-name='a'/>", "<test> is a test in Python with launch_testing in ROS 2"),
        ("<arg name='a' value='b'/>", "<arg value=…> is <let name=… value=…/> in ROS 2"),
        ("<rosparam command='load'/>", "<rosparam> is <param from=…/> in a node in ROS 2"),
        (
            "<group ns='a'><node pkg='a' type='b'/></group>",
            "<group ns=…> is <push_ros_namespace namespace=…/> in the group in ROS 2",
        ),
    ],
)
def test_a_file_of_ros_1_is_told_by_its_line_and_what_it_would_be_in_ros_2(write, line, expected):
    path = write(f"<launch>\n<arg name='sim'/>\n{line}\n<rosparam/>\n</launch>")
    with pytest.raises(TeleopctlError, match=f"ROS 1: {expected}") as caught:
        read_launch_file(path)
    assert caught.value.message.startswith(f"{path}:3:")
    assert caught.value.hint == "Its other lines of ROS 1: 4."


def test_a_file_that_has_only_what_ros_1_has_is_one_of_ros_1(write):
    with pytest.raises(TeleopctlError, match=":1: this is a launch file of ROS 1: <remap>"):
        read_launch_file(write("<launch><remap from='a' to='b'/></launch>"))


@pytest.mark.parametrize("text", ["<node pkg='a' exec='b'/>", "<log message='$(var a)'/>"])
def test_a_mistake_in_a_file_of_ros_2_is_a_mistake(write, text):
    with pytest.raises(TeleopctlError, match="unknown attribute 'value', expected one of name"):
        read_launch_file(write(f"<launch>{text}<arg name='a' value='b'/></launch>"))


@pytest.mark.parametrize(
    "text",
    [
        r"<arg name='a' description='as $(arg x) was'/>",
        r"<let name='a' value='\$(find arm)'/>",
        "<!-- <node type='b'/> --><let name='a' value='b'/>",
    ],
)
def test_a_word_of_ros_1_that_means_nothing_does_not_make_a_file_one_of_ros_1(write, text):
    assert len(read_launch_file(write(f"<launch version='0.1.1'>{text}</launch>")).steps) == 1


@pytest.mark.parametrize(
    ("attributes", "value"),
    [
        ('value="1"', 1),
        ('value="1.0"', 1.0),
        ('value="1e-3"', 1e-3),
        ('value="true"', True),
        ('value="a b"', "a b"),
        ("value=\"'1'\"", "1"),
        ("value=\"''\"", ""),
        ('value=""', ""),
        ('value="[1, 2.5]"', [1.0, 2.5]),
        ('value="[1, $(eval 1 + 1)]"', [1, 2]),
        ('value="{a: 1}"', "{a: 1}"),
        ('value="1" type="str"', "1"),
        ('value="\'1\'" type="str"', "'1'"),
        ('value="1" type="float"', 1.0),
        ('value="[1, 2]" type="list_of_float"', [1.0, 2.0]),
        ('value="2, 5, 8" value-sep=", "', [2, 5, 8]),
        ("value=\"'2';'5'\" value-sep=\";\"", ["2", "5"]),
        ('value="2;5" value-sep=";" type="list_of_str"', ["2", "5"]),
        ('value="\'2\';\'5\'" value-sep=";" type="list_of_str"', ["'2'", "'5'"]),
        ('value="2.;5." value-sep=";"', [2.0, 5.0]),
        ('value="$(eval 1 + 1)"', 2),
        ('value="$(eval 1 + 1)" type="str"', "2"),
        ('value="&lt;robot name=&quot;x&quot;/&gt;"', '<robot name="x"/>'),
    ],
)
def test_a_parameter_has_the_type_that_its_text_has_in_yaml(parameter, attributes, value):
    assert parameter(attributes) == value
    assert type(parameter(attributes)) is type(value)


def test_other_attributes_are_the_text_that_stands_there(plan):
    text = """
        <arg name="version" default="1.0"/>
        <let name="flag" value="yes"/>
        <executable cmd="echo $(var version) $(var flag) 0x10"/>
    """
    assert plan(text).processes[0].command == ["echo", "1.0", "yes", "0x10"]


def test_a_tag_is_an_action_or_belongs_to_one_by_where_it_stands(plan, write):
    write("<launch/>").with_name("other.launch.xml").write_text(
        '<launch><arg name="word"/><executable cmd="echo $(var word)"/></launch>'
    )
    text = """
        <group>
          <arg name="word" default="inner"/>
          <executable cmd="echo $(var word)"/>
          <let name="word" value="set"/>
          <include file="other.launch.xml"/>
          <include file="other.launch.xml">
            <arg name="word" value="given"/>
            <let name="other" value="x"/>
          </include>
        </group>
    """
    assert [process.command[1] for process in plan(text).processes] == ["inner", "set", "given"]


def test_a_file_that_calls_itself_deprecated_warns(write, tmp_path):
    path = write("<launch deprecated='Use new.launch.xml.'/>")
    evaluated, _ = evaluate(read_launch_file(path), {}, tmp_path / "log")
    assert evaluated.start.messages == [
        ("WARNING", "launch.user", f"launch file [{path}] is deprecated: Use new.launch.xml.")
    ]


def test_a_file_of_another_ending_is_no_launch_file(tmp_path):
    with pytest.raises(TeleopctlError, match=r"file\.toml is not a launch file") as caught:
        read_launch_file(tmp_path / "file.toml")
    assert ".xml" in str(caught.value.hint)


names = st.sampled_from(["node", "group", "param", "let", "arg", "include", "timer", "choice"])
attributes = st.dictionaries(
    st.sampled_from(["name", "value", "value-sep", "pkg", "exec", "if", "scoped", "children"]),
    st.text("ab $()'[]:,\\", max_size=6),
    max_size=4,
)
# Any: name, attributes and nested tags of the same form.
tags: st.SearchStrategy[Any] = st.recursive(
    st.tuples(names, attributes, st.just([])),
    lambda nested: st.tuples(names, attributes, st.lists(nested, max_size=3)),
    max_leaves=8,
)


def written(tag):
    name, attributes, nested = tag
    text = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"<{name}{text}>\n{''.join(map(written, nested))}</{name}>"


@given(st.lists(tags, max_size=3))
def test_any_tags_are_read_or_refused(tmp_path_factory, given_tags):
    path = tmp_path_factory.getbasetemp() / "any.launch.xml"
    path.write_text(f"<launch>{''.join(map(written, given_tags))}</launch>", encoding="utf-8")
    try:
        read_launch_file(path)
    except TeleopctlError as error:
        assert str(path) in error.message
