"""Launch variables and environment of Python launch files: what reaches whom."""

import os
from unittest import mock

import pytest
from hypothesis import given, strategies as st
from launch import LaunchContext, LaunchDescription
from launch._entities import steps
from launch.actions import (
    AppendEnvironmentVariable,
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from launch.launch_description_source import LaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PythonExpression

from teleopctl.errors import TeleopctlError

NAMES = st.sampled_from(["a", "b"])
VALUES = st.sampled_from(["1", "2"])
ACTIONS = st.recursive(
    st.one_of(
        st.tuples(st.just("set"), NAMES, VALUES),
        st.tuples(st.just("unset"), NAMES),
        st.tuples(st.just("set_env"), NAMES, VALUES),
        st.tuples(st.just("unset_env"), NAMES),
        st.tuples(st.just("reset")),
        st.tuples(st.just("reset_env")),
    ),
    lambda inner: st.one_of(
        st.tuples(st.just("pushed"), st.lists(inner, max_size=3)),
        st.tuples(st.just("include"), NAMES, VALUES, st.lists(inner, max_size=3)),
        st.tuples(
            st.just("group"), st.booleans(), st.booleans(), NAMES, st.lists(inner, max_size=3)
        ),
    ),
    max_leaves=8,
)


def entities(program):
    """The actions of a program."""
    for name, *rest in program:
        match name, rest:
            case "set", (variable, value):
                yield SetLaunchConfiguration(f"v_{variable}", value)
            case "unset", (variable,):
                yield UnsetLaunchConfiguration(f"v_{variable}")
            case "set_env", (variable, value):
                yield SetEnvironmentVariable(f"E_{variable}", value)
            case "unset_env", (variable,):
                yield UnsetEnvironmentVariable(f"E_{variable}")
            case "reset", ():
                yield ResetLaunchConfigurations({"kept": "1"})
            case "reset_env", ():
                yield ResetEnvironment()
            case "pushed", (inner,):
                yield PushLaunchConfigurations()
                yield PushEnvironment()
                yield from entities(inner)
                yield PopEnvironment()
                yield PopLaunchConfigurations()
            case "include", (variable, value, inner):
                source = LaunchDescriptionSource(LaunchDescription(list(entities(inner))))
                pairs = [(f"v_{variable}", value)]
                yield IncludeLaunchDescription(source, launch_arguments=pairs)
            case "group", (scoped, forwarding, variable, inner):
                given = {f"v_{variable}": "given"}
                yield GroupAction(
                    list(entities(inner)),
                    scoped=scoped,
                    forwarding=forwarding,
                    launch_configurations=given,
                )


def expected(program, variables, environment):
    """What a program leaves behind, by the words of ROS 2's documentation."""
    for name, *rest in program:
        match name, rest:
            case "set", (variable, value):
                variables = {**variables, f"v_{variable}": value}
            case "unset", (variable,):
                variables = {key: variables[key] for key in variables if key != f"v_{variable}"}
            case "set_env", (variable, value):
                environment = {**environment, f"E_{variable}": value}
            case "unset_env", (variable,):
                environment = {k: environment[k] for k in environment if k != f"E_{variable}"}
            case "reset", ():
                variables = {"kept": "1"}
            case "reset_env", ():
                environment = {}
            case "pushed", (inner,):
                expected(inner, variables, environment)
            case "include", (variable, value, inner):
                variables = {**variables, f"v_{variable}": value}
                variables, environment = expected(inner, variables, environment)
            case "group", (scoped, forwarding, variable, inner):
                given = {f"v_{variable}": "given"}
                if not scoped:
                    variables, environment = expected(inner, {**variables, **given}, environment)
                elif forwarding:
                    expected(inner, {**variables, **given}, environment)
                else:
                    expected(inner, given, {})
    return variables, environment


@given(st.lists(ACTIONS, max_size=5))
def test_what_is_set_reaches_whom_it_reaches_in_ros_2(program):
    seen = []
    with mock.patch.dict(os.environ):
        context = LaunchContext()
        look = OpaqueFunction(function=lambda _: seen.append(dict(os.environ)))
        context.launch.run(steps([*entities(program), look]))
        for found in (dict(context.environment), *seen):
            environment = {key: value for key, value in found.items() if key[:2] == "E_"}
            assert (context.launch_configurations, environment) == expected(program, {}, {})


def test_the_steps_of_a_group_see_what_it_gives_them():
    context = LaunchContext()
    context.launch_configurations.update(seen="1", hidden="2")
    seen = []

    def look(context):
        seen.append(dict(context.launch_configurations))

    group = GroupAction(
        [OpaqueFunction(function=look)],
        forwarding=False,
        launch_configurations={"seen": LaunchConfiguration("seen"), "new": "3"},
    )
    context.launch.run(steps([group]))
    assert seen == [{"seen": "1", "new": "3"}]


def test_a_value_is_put_behind_that_of_a_variable_or_before_it(monkeypatch):
    monkeypatch.setenv("E_PATH", "a")
    context = LaunchContext()
    AppendEnvironmentVariable("E_PATH", "b").visit(context)
    AppendEnvironmentVariable("E_PATH", "c", prepend=True, separator="-").visit(context)
    assert context.environment["E_PATH"] == os.environ["E_PATH"] == f"c-a{os.pathsep}b"


def test_what_was_not_remembered_cannot_come_back():
    with pytest.raises(RuntimeError, match="launch_configurations stack unexpectedly empty"):
        PopLaunchConfigurations().visit(LaunchContext())
    with pytest.raises(RuntimeError, match="environment stack unexpectedly empty"):
        PopEnvironment().visit(LaunchContext())


def test_an_included_description_is_given_what_it_requires_by_who_includes_it():
    inner = LaunchDescription([DeclareLaunchArgument("foo")])
    context = LaunchContext()
    context.launch_configurations["foo"] = "set outside"
    with pytest.raises(TeleopctlError, match="missing required argument 'foo'"):
        context.launch.run(steps(IncludeLaunchDescription(LaunchDescriptionSource(inner))))


def test_the_exception_of_an_action_that_is_executed_by_hand_has_no_circle_of_causes():
    action = LogInfo(msg=PythonExpression(["1 / 0"]))
    with pytest.raises(ZeroDivisionError) as raised:
        action.execute(LaunchContext())
    assert raised.value.__cause__ is None
