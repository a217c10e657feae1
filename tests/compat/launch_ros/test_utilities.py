"""``launch_ros.utilities``: parameters, names and namespaces, as a launch itself treats them."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, strategies as st
from launch import LaunchContext
from launch.substitutions import LaunchConfiguration, SubstitutionFailure, TextSubstitution
from launch.utilities.type_utils import coerce_to_type
from launch_ros.actions import Node, PushROSNamespace, SetRemap
from launch_ros.descriptions import Parameter, ParameterFile, ParameterValue
from launch_ros.utilities import (
    add_node_name,
    evaluate_parameters,
    get_node_name_count,
    make_namespace_absolute,
    normalize_parameters,
    normalize_remap_rule,
    prefix_namespace,
    to_parameters_list,
)

from teleopctl.errors import InvalidFileError
from teleopctl.launch.model.scope import join_namespace

WORDS = st.text("abz019._-", min_size=1)
NUMBERS = st.floats(-1e6, 1e6) | st.integers(-(2**40), 2**40)
WRITTEN = st.sampled_from(["true", "off", "3", "0.5", "text", "'7'", "[1, 2]", "[a, b]", ""])
SUBSTITUTIONS = WRITTEN.map(lambda text: TextSubstitution(text=text))
VALUES = (
    st.booleans()
    | NUMBERS
    | WORDS
    | SUBSTITUTIONS
    | st.lists(NUMBERS, min_size=1)
    | st.lists(WORDS, min_size=1)
    | st.lists(st.booleans(), min_size=1)
    | WORDS.map(lambda word: [word, TextSubstitution(text="x")])
    | WORDS.map(lambda word: [[word, TextSubstitution(text="x")], "y"])
    | WORDS.map(lambda word: ParameterValue(TextSubstitution(text=word), value_type=str))
)
NAMES = st.text("abc", min_size=1)
MAPPINGS = st.dictionaries(
    NAMES,
    VALUES | st.dictionaries(NAMES.map(lambda name: f"_{name}"), VALUES, min_size=1),
    min_size=1,
)


@given(MAPPINGS)
def test_parameters_evaluate_to_what_a_node_of_the_launch_is_given(mapping):
    context = LaunchContext()
    (evaluated,) = evaluate_parameters(context, normalize_parameters([mapping]))
    assert isinstance(evaluated, dict)
    node = Node(executable="program", parameters=[mapping])
    builder = context.launch._builder  # what a launch writes, without one that is run
    builder.build(node.process())
    (content,) = builder.files.values()
    given_to_node = yaml.safe_load(content)["/**"]["ros__parameters"]
    as_in_yaml = {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in evaluated.items()
    }
    assert as_in_yaml == given_to_node
    assert repr(as_in_yaml) == repr(given_to_node)  # 1 is not 1.0, nor True


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ([True, 2.0, 3], "Expected a non-empty sequence"),
        (TextSubstitution(text="[1, a]"), "Expected a non-empty sequence"),
        (TextSubstitution(text="{a: 1}"), "Allowed value types"),
        (TextSubstitution(text="a: b: c"), "Unable to parse"),
        ({1, 2}, "Unexpected type"),
        ([1, [[2]]], "normalize"),
    ],
)
def test_what_no_parameter_can_be_is_refused(value, words):
    with pytest.raises(TypeError, match=words):
        evaluate_parameters(LaunchContext(), normalize_parameters([{"name": value}]))


@pytest.mark.parametrize("wrong", ["file.yaml", {"name": 1}, [5.0]])
def test_parameters_are_a_list_of_files_and_mappings(wrong):
    with pytest.raises(TypeError):
        normalize_parameters(wrong)
    with pytest.raises(TypeError):
        Node(executable="program", parameters=wrong)


def test_a_file_with_substitutions_is_read_with_what_is_known_when_it_is_evaluated(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("/**: {ros__parameters: {name: $(var who)}}")
    context = LaunchContext()
    context.launch_configurations.update(who="me", evaluates="true")
    file = ParameterFile(str(path), allow_substs=LaunchConfiguration("evaluates"))
    plain = ParameterFile(path)
    made, unchanged = evaluate_parameters(context, normalize_parameters([file, plain]))
    assert isinstance(made, Path)
    assert yaml.safe_load(made.read_text()) == {"/**": {"ros__parameters": {"name": "me"}}}
    assert unchanged == path
    assert [file.param_file, file.allow_substs] == [made, True]
    file.cleanup()
    assert not made.exists()
    assert path.exists()


@pytest.mark.parametrize("text", ['!!int ""', '!!float ""', "!!timestamp x"])
def test_an_explicit_tag_that_does_not_fit_is_refused_as_yaml(tmp_path, text):
    value = TextSubstitution(text=text)
    with pytest.raises(TypeError, match="Unable to parse the value of parameter name as yaml"):
        evaluate_parameters(LaunchContext(), normalize_parameters([{"name": value}]))
    with pytest.raises(ValueError, match="using yaml rules"):
        coerce_to_type(text, None)
    path = tmp_path / "p.yaml"
    path.write_text(f"/**:\n  ros__parameters:\n    x: {text}\n")
    with pytest.raises(SubstitutionFailure):
        ParameterFile(path, allow_substs=True).evaluate(LaunchContext())
    with pytest.raises(InvalidFileError, match=r"p\.yaml:3: not YAML: '.*' is no !!"):
        to_parameters_list(LaunchContext(), "me", "", [path])


def test_a_parameter_is_evaluated_once():
    context = LaunchContext()
    context.launch_configurations["n"] = "3"
    parameter = Parameter("a.b", LaunchConfiguration("n"), value_type=int)
    assert parameter.evaluate(context) == ("a.b", 3)
    context.launch_configurations["n"] = "4"
    assert parameter.evaluate(context) == (parameter.name, parameter.value) == ("a.b", 3)


def test_files_give_a_node_what_they_say_of_it_its_own_name_last(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(
        "/ns: {me: {ros__parameters: {a: 1, b: [1.5]}}, other: {ros__parameters: {d: 1}}}\n"
        "/**: {ros__parameters: {a: 2, c: 'x'}}\n"
        "/*: {ros__parameters: {e: true}}\n"
    )
    context = LaunchContext()
    found = to_parameters_list(context, "me", "ns", [path, {"f": True}])
    assert {each.name: each.value for each in found} == {"a": 1, "b": (1.5,), "c": "x", "f": True}
    outside = to_parameters_list(context, "me", "", [path])
    assert {each.name: each.value for each in outside} == {"a": 2, "c": "x", "e": True}


@given(st.lists(NAMES).map("/".join), st.lists(NAMES).map("/".join), st.booleans())
def test_namespaces_are_joined_as_the_launch_joins_them(outer, inner, absolute):
    outer, inner = f"/{outer}", f"/{inner}" if absolute else inner
    assert make_namespace_absolute(prefix_namespace(outer, inner)) == join_namespace(outer, inner)


@pytest.mark.parametrize("wrong", [["a", "b"], ("a", "b", "c"), "ab"])
def test_a_remapping_is_a_tuple_of_two(wrong):
    with pytest.raises(TypeError):
        normalize_remap_rule(wrong)
    with pytest.raises(TypeError):
        Node(executable="program", remappings=[wrong])


def test_nodes_of_the_same_name_are_counted_and_told():
    context = LaunchContext()
    for _ in range(2):
        Node(executable="program", name="me", namespace="ns").visit(context)
    Node(executable="program", name="alone").visit(context)  # nobody knows in which namespace
    add_node_name(context, "/ns/me")
    assert get_node_name_count(context, "/ns/me") == 3
    assert get_node_name_count(context, "/alone") == 0
    (message,) = context.launch.take_follow_up().messages
    assert message[0] == "WARNING"
    assert "at least 2 nodes with the name /ns/me" in message[2]


class OwnContext:
    """What tests of launch files hand over in place of a context."""

    def __init__(self):
        self.launch_configurations = {}

    def perform_substitution(self, substitution):
        return substitution.perform(None)


def test_a_node_is_evaluated_without_a_launch_for_subclasses_and_tests_of_launch_files():
    context: Any = OwnContext()
    PushROSNamespace("outer").execute(context)
    SetRemap("from", "to").execute(context)
    assert context.launch_configurations == {
        "ros_namespace": "/outer",
        "ros_remaps": [("from", "to")],
    }
    # Any: names that are private in ROS 2.
    node: Any = Node(
        package="unknown", executable="program", name="eye", namespace="inner",
        parameters=[{"gain": 2}], remappings=[("a", "b")], arguments=["x"],
    )  # fmt: skip
    node._perform_substitutions(context)
    assert node.node_name == "/outer/inner/eye"
    assert node._Node__expanded_remappings == [("from", "to"), ("a", "b")]
    ((file, is_file),) = node._Node__expanded_parameter_arguments
    assert is_file
    assert yaml.safe_load(Path(file).read_text()) == {"/**": {"ros__parameters": {"gain": 2}}}
    assert evaluate_parameters(LaunchContext(), node._Node__parameters) == ({"gain": 2},)
    assert (node._Node__package, node._Node__node_executable) == ("unknown", "program")
    assert (node._Node__arguments, len(node._Node__remappings)) == (["x"], 1)
    # It is counted where it is started, not here.
    known = LaunchContext()
    node._perform_substitutions(known)
    assert get_node_name_count(known, "/inner/eye") == 0
