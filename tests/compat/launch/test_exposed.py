"""Actions and substitutions that a program makes known stand in text launch files."""

import pytest
from launch import Action, Substitution
from launch.actions import ExecuteProcess, LogInfo
from launch.frontend import Entity, Parser, expose_action, expose_substitution
from launch.frontend.parse_substitution import parse_substitution
from launch.substitutions import EnvironmentVariable, TextSubstitution

from teleopctl.errors import TeleopctlError
from teleopctl.launch import LaunchRequest, evaluate_request
from tests.compat.activated import output
from tests.distributions import install


@expose_action("greet_twice")
class GreetTwice(Action):
    def __init__(self, whom, more=(), **kwargs):
        super().__init__(**kwargs)
        self.whom, self.more = whom, more

    @classmethod
    def parse(cls, entity: Entity, parser: Parser):
        _, kwargs = super().parse(entity, parser)
        kwargs["whom"] = parser.parse_substitution(entity.get_attr("whom"))
        kwargs["more"] = [parser.parse_action(child) for child in entity.children]
        return cls, kwargs

    def execute(self, context):
        return [LogInfo(msg=["hello ", *self.whom]), *self.more]


@expose_substitution("shouted")
def shouted(data):
    class Shouted(TextSubstitution):
        pass

    return Shouted, {"text": data[0][0].text.upper()}


YAML = """launch:
- greet_twice:
    whom: $(shouted you)
    children: [{log: {message: and me}}]
- greet_twice: {whom: nobody, if: false, children: []}
"""
XML = """<launch>
<greet_twice whom="$(shouted you)"><log message="and me"/></greet_twice>
<greet_twice whom="nobody" unless="true"/>
</launch>
"""


def said(path, text):
    path.write_text(text, encoding="utf-8")
    plan, _ = evaluate_request(LaunchRequest(file=str(path)), path.parent)
    return [message for _, _, message in plan.start.messages]


@pytest.mark.parametrize(("name", "text"), [("a.yaml", YAML), ("a.launch.xml", XML)])
def test_an_action_of_ones_own_stands_among_the_others(tmp_path, name, text):
    assert said(tmp_path / name, text) == ["hello YOU", "and me"]


def test_a_key_that_nobody_reads_is_told_with_its_line(tmp_path):
    with pytest.raises(TeleopctlError, match=r"a\.yaml:2: .*Unexpected attribute.*'who'"):
        said(tmp_path / "a.yaml", "launch:\n- greet_twice: {whom: a, who: b, children: []}\n")


def test_a_name_is_made_known_once():
    with pytest.raises(RuntimeError, match="exposed with the same name"):
        expose_substitution("shouted")(lambda data: data)
    with pytest.raises(RuntimeError, match="class method called 'parse'"):
        expose_action("nothing")(type("Nothing", (), {}))


def test_a_text_is_parsed_into_substitutions():
    begin, variable = parse_substitution("in $(env PLACE here)")
    assert isinstance(begin, TextSubstitution)
    assert begin.text == "in "
    assert isinstance(variable, EnvironmentVariable)
    assert variable.describe() == "EnvVar('PLACE')"
    assert variable.default_value is not None
    assert [part.describe() for part in variable.default_value] == ["'here'"]


class Told(Substitution):
    def perform(self, context):
        return "told"


@expose_substitution("told")
def told(data):
    return Told, {}


def test_a_command_line_keeps_the_substitutions_that_stand_in_it():
    words = ExecuteProcess._parse_cmdline("run 'a $(told)' $(env B)c", Parser())
    assert [[type(part) for part in word] for word in words] == [
        [TextSubstitution],
        [TextSubstitution, Told],
        [EnvironmentVariable, TextSubstitution],
    ]


def test_installed_distributions_bring_actions_and_substitutions(tmp_path):
    install(
        tmp_path / "site",
        "greetings",
        {"launch.frontend.launch_extension": {"greetings": "greetings", "broken": "nothing_there"}},
        {
            "greetings.py": """
            from launch.actions import LogInfo
            from launch.frontend import expose_action, expose_substitution
            from launch.substitutions import TextSubstitution

            @expose_action("greet")
            def greet(entity, parser):
                return LogInfo, {"msg": parser.parse_substitution(entity.get_attr("whom"))}

            @expose_substitution("quietly")
            def quietly(data):
                return TextSubstitution, {"text": data[0][0].text.lower()}
            """
        },
    )
    path = tmp_path / "greets.yaml"
    path.write_text("launch: [log: {message: $(quietly HELLO)}, greet: {whom: everybody}]")
    read = f"""
import warnings
from pathlib import Path
from teleopctl.launch import LaunchRequest, evaluate_request
with warnings.catch_warnings(record=True) as caught:
    plan, _ = evaluate_request(LaunchRequest(file={str(path)!r}), Path("log"))
print([text for _, _, text in plan.start.messages], *(each.message for each in caught))
"""
    told = output(read, tmp_path / "site")
    assert told.startswith("['hello', 'everybody'] Failed to load the launch extension: broken")
