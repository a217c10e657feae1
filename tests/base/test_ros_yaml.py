"""What plain words of YAML are in ROS 2, and that nothing but a YAML error comes of bad ones."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, strategies as st

from teleopctl.base import ros_yaml
from teleopctl.errors import LaunchError


def test_plain_words_are_what_ros_2_takes_them_for():
    text = "[1e-3, -2E+5, 1.5, 12, true, 1.2.3, 2020-01-31, 2020-13-45, 2020-01-31 10:00:00]"
    assert ros_yaml.load(text) == [
        *[0.001, -200000.0, 1.5, 12, True],
        *["1.2.3", "2020-01-31", "2020-13-45", "2020-01-31 10:00:00"],
    ]


@pytest.mark.parametrize("text", ["!!int x", "!!float x", "!!timestamp 2020-13-45", "{a: [}"])
def test_what_cannot_be_read_is_a_yaml_error(text):
    with pytest.raises(yaml.YAMLError):
        ros_yaml.load(text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        # libyaml may be the first to refuse it.
        ("[" * 100_000, "nested more than 100 deep|exceeded maximum nesting depth"),
        ("- " * 100_000 + "a", "nested more than 100 deep"),
        ("[" * 200 + "]" * 200, "nested more than 100 deep"),
        ("a0: &a0 []\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 200)), "nested"),
        ("&a [*a]", r"'\*a' refers to a value that contains it"),
        ("&a {b: {<<: *a}}", r"'\*a' refers to a value that contains it"),
        (
            "a0: &a0 [x, x]\n"
            + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 40)),
            "aliases expand to more than 100,000 values",
        ),
        (
            "a0: &a0 {k: x}\n"
            + "".join(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}]}}\n" for i in range(1, 40)),
            "aliases expand to more than 100,000 values",
        ),
        ("a: 0x" + "f" * 5000, "an integer of too many digits"),
        ("a: 1" + ":1" * 5000, "an integer of too many digits"),
    ],
)
def test_what_would_fill_the_memory_or_the_stack_is_refused_with_its_line(text, reason):
    with pytest.raises(yaml.MarkedYAMLError, match=reason) as refused:
        ros_yaml.load(text)
    assert refused.value.problem_mark is not None
    with pytest.raises(yaml.YAMLError, match=reason):
        ros_yaml.RosLoader(text).get_single_data()


def test_aliases_as_files_for_people_have_them_are_read():
    text = "base: &base {a: 1, b: &list [1, 2]}\nrobot: {<<: *base, c: *list}\nagain: *base\n"
    assert ros_yaml.load(text)["robot"] == {"a": 1, "b": [1, 2], "c": [1, 2]}
    assert ros_yaml.load("[" * 99 + "]" * 99)


@given(st.recursive(st.integers() | st.text("ab{}[]*&- :\n"), st.lists, max_leaves=40))
def test_no_data_of_ordinary_size_is_refused(data):
    assert ros_yaml.load(yaml.safe_dump(data)) == data


def test_a_fault_of_a_file_is_told_with_its_line_as_an_error_of_the_readers_kind():
    with pytest.raises(LaunchError) as error, ros_yaml.faults_of(Path("a.yaml"), LaunchError):
        ros_yaml.load("one: 1\ntwo: [")
    assert error.value.message.startswith("a.yaml:3: not YAML: ")


TAGS = ["int", "float", "bool", "null", "str", "binary", "timestamp", "seq", "map", "set", "omap"]
TAGS += ["pairs", "merge", "value", "yaml", "unknown", "python/object:os.system"]
ODD = ['""', '" "', "x", "-", "+", ".", "0x", "0b2", "1:", "_", "1e999", "~", "é", '"\\0"', "=="]
ODD += ["2020-13-45", "2020-01-01 25:00:00", "[]", "[[1, 2]]", "[{a: 1, b: 2}]", "{a: 1}"]
ODD += ["{=: 1}", "{<<: 1}", "{[1]: 2}", ""]


@given(
    tag=st.sampled_from(TAGS),
    value=st.sampled_from(ODD) | st.text(max_size=12).map(repr),
    place=st.sampled_from(["{}", "a: {}", "[{}]", "{{{}: 1}}", "a: &x {}\nb: *x"]),
)
def test_of_an_explicit_tag_there_comes_a_value_or_a_yaml_error_with_its_line(tag, value, place):
    text = place.format(f"!!{tag} {value}")
    for load in (ros_yaml.load, ros_yaml.load_merged, ros_yaml.safe_load):
        try:
            load(text)
        except yaml.MarkedYAMLError as error:
            assert error.problem_mark is not None
        except yaml.reader.ReaderError:
            pass  # a character that YAML does not allow at all


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('!!int ""', "'' is no !!int"),
        ('!!float " "', "' ' is no !!float"),
        ("!!bool maybe", "'maybe' is no !!bool"),
        ("!!timestamp {=: 1}", "this is no !!timestamp"),
    ],
)
def test_the_reason_names_value_and_tag(text, reason):
    with pytest.raises(yaml.MarkedYAMLError) as refused:
        ros_yaml.load(f"fine: 1\nx: {text}")
    assert refused.value.problem == reason
    assert refused.value.problem_mark is not None
    assert refused.value.problem_mark.line == 1
