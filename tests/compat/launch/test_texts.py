"""Substitutions and conditions of Python launch files: what they stand for, and when they hold."""

import pytest
from launch import LaunchContext
from launch.conditions import (
    IfCondition,
    InvalidConditionExpressionError,
    LaunchConfigurationEquals,
    LaunchConfigurationNotEquals,
    UnlessCondition,
)
from launch.substitutions import (
    AllSubstitution,
    AndSubstitution,
    AnonName,
    AnySubstitution,
    Command,
    EnvironmentVariable,
    EqualsSubstitution,
    FileContent,
    FindExecutable,
    IfElseSubstitution,
    LaunchConfiguration,
    LocalSubstitution,
    NotEqualsSubstitution,
    NotSubstitution,
    OrSubstitution,
    PathJoinSubstitution,
    PathSubstitution,
    PythonExpression,
    StringJoinSubstitution,
    SubstitutionFailure,
    TextSubstitution,
    ThisLaunchFile,
)


@pytest.fixture
def context(monkeypatch, tmp_path):
    monkeypatch.setenv("PLACE", "here")
    (tmp_path / "words.txt").write_text("some words", encoding="utf-8")
    made = LaunchContext()
    made.launch_configurations.update(map="hall", folder=str(tmp_path))
    made.extend_locals({"turn": ["first", "second"]})
    return made


MAP = LaunchConfiguration("map")


@pytest.mark.parametrize(
    ("substitution", "text"),
    [
        (TextSubstitution(text="$(var map)"), "$(var map)"),
        (MAP, "hall"),
        (LaunchConfiguration(["m", "ap"]), "hall"),
        (LaunchConfiguration("nowhere", default=[1, "-", MAP]), "1-hall"),
        (EnvironmentVariable("PLACE"), "here"),
        (EnvironmentVariable("NO_PLACE", default_value=MAP), "hall"),
        (PathJoinSubstitution(["maps", [MAP, ".yaml"]]), "maps/hall.yaml"),
        (PathSubstitution("maps") / "old" / [MAP, ".yaml"], "maps/old/hall.yaml"),
        (StringJoinSubstitution(["a", MAP, ["b", "c"]], delimiter="-"), "a-hall-bc"),
        (FileContent([LaunchConfiguration("folder"), "/words.txt"]), "some words"),
        (Command(["echo ", MAP]), "hall\n"),
        (PythonExpression(["len('", MAP, "') + floor(1.5)"]), "5"),
        (PythonExpression("json.dumps([1])", python_modules=["json"]), "[1]"),
        (LocalSubstitution("turn[1]"), "second"),
        (IfElseSubstitution("yes", MAP, "none"), "hall"),
        (EqualsSubstitution(MAP, "hall"), "true"),
        (EqualsSubstitution(1, "1.0"), "true"),
        (EqualsSubstitution(True, "1"), "true"),
        (EqualsSubstitution(None, ""), "true"),
        (NotEqualsSubstitution(MAP, "yard"), "true"),
        (NotSubstitution("off"), "true"),
        (AndSubstitution("true", "0"), "false"),
        (OrSubstitution("true", "0"), "true"),
        (AnySubstitution("false", "no"), "false"),
        (AllSubstitution(container=["on", "1"]), "true"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_substitution_stands_for_a_text(context, substitution, text):
    assert substitution.perform(context) == text


@pytest.mark.parametrize(
    ("substitution", "reason"),
    [
        (LaunchConfiguration("mop"), "launch configuration 'mop' does not exist"),
        (EnvironmentVariable("NO_PLACE"), "environment variable 'NO_PLACE' does not exist"),
        (FindExecutable(name="no_such_program"), "'no_such_program' not found on the PATH"),
        (Command("false"), "executed command failed. Command: false"),
        (FileContent("/no/file"), "File not found: /no/file"),
        (NotSubstitution("perhaps"), "expected true or false, got 'perhaps'"),
        (ThisLaunchFile(), "ThisLaunchFile used outside of a launch file"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_cannot_be_told_is_a_failure_of_the_substitution(context, substitution, reason):
    with pytest.raises(SubstitutionFailure, match=reason):
        substitution.perform(context)


def test_an_anonymous_name_is_the_same_for_the_same_word(context):
    first, again, other = (AnonName(word).perform(context) for word in ("eye", "eye", "ear"))
    assert first == again != other
    assert first.startswith("eye_")


@pytest.mark.parametrize(
    ("substitution", "words"),
    [
        (MAP, "LaunchConfig('map')"),
        (EnvironmentVariable("PLACE"), "EnvVar('PLACE')"),
        (Command(["xacro ", MAP]), "Command('xacro ' + LaunchConfig('map'))"),
        (PathJoinSubstitution(["a", [MAP, ".b"]]), "PathJoinSubstitution(''a', LaunchC"),
        (PythonExpression("1"), "PythonExpr('1', ['math'])"),
    ],
)
def test_a_substitution_describes_itself_as_in_ros_2(substitution, words):
    assert substitution.describe().startswith(words)


@pytest.mark.parametrize("word", ["true", "True", " 1 "])
def test_a_condition_holds_for_a_true_word_and_its_opposite_does_not(context, word):
    assert IfCondition(word).evaluate(context)
    assert not UnlessCondition([word]).evaluate(context)


@pytest.mark.parametrize("word", ["", "yes", "hall"])
def test_a_word_that_is_no_truth_value_is_no_condition(context, word):
    with pytest.raises(InvalidConditionExpressionError, match="expected one of"):
        IfCondition(word).evaluate(context)


def test_a_condition_on_a_variable_warns_of_its_age(context):
    def holds(kind, name, value):
        with pytest.warns(UserWarning, match="deprecated"):
            condition = kind(name, value)
        return condition.evaluate(context)

    assert holds(LaunchConfigurationEquals, "map", ["ha", "ll"])
    assert holds(LaunchConfigurationEquals, "nowhere", None)
    assert holds(LaunchConfigurationNotEquals, "map", None)
    assert not holds(LaunchConfigurationNotEquals, "map", MAP)
