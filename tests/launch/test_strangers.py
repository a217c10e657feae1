"""Actions, substitutions and languages of other distributions in a launch file."""

import pytest

from teleopctl.errors import LaunchError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.finding import find_launch_file
from teleopctl.launch.frontends import read_launch_file
from teleopctl.plugins import lookup
from tests.distributions import install

CODE = """
    from dataclasses import dataclass

    from teleopctl.launch.actions.messages import Log
    from teleopctl.launch.evaluation.substitution import Substitution
    from teleopctl.launch.model.action import Action, LaunchFile, Step
    from teleopctl.launch.model.descriptions import Place
    from teleopctl.launch.model.template import literal

    @dataclass(frozen=True)
    class Twice(Action):
        keys = ("message", "children")
        message: object
        steps: tuple

        @classmethod
        def parse(cls, entity):
            return cls(entity.required("message"), entity.steps("children"))

        def evaluate(self, launch):
            text = launch.text(self.message)
            launch.run(self.steps)
            if text == "explode":
                return 1 / 0
            return [Log(message=literal(text))] * 2

    UPPER = Substitution(lambda arguments, context: arguments[0].upper(), 1, 1)
    BAD = Substitution(lambda arguments, context: arguments[7])

    def read(path):
        return LaunchFile(path, (Step(Place(path, 1), (), Log(message=literal("read"))),))
"""
ENTRIES = {
    "teleopctl.launch_actions": {"twice": "strange_launch:Twice", "gone": "strange_gone:Gone"},
    "teleopctl.launch_languages": {".strange": "strange_launch:read"},
    "teleopctl.launch_substitutions": {
        "upper": "strange_launch:UPPER",
        "bad": "strange_launch:BAD",
        "unlike": "strange_launch:Twice",
    },
}


@pytest.fixture
def plan(tmp_path, monkeypatch):
    install(tmp_path, "strange-launch", ENTRIES, {"strange_launch.py": CODE})
    monkeypatch.syspath_prepend(str(tmp_path))
    lookup.forget_entry_points()

    def plan(*lines, name="file.yaml"):
        file = tmp_path / name
        file.write_text("\n".join(["launch:" if name.endswith("yaml") else "", *lines]).strip())
        return evaluate(read_launch_file(file), {}, tmp_path / "log")[0]

    yield plan
    lookup.forget_entry_points()


def test_a_strangers_action_gives_actions_and_runs_its_children(plan):
    done = plan(
        "- twice:",
        "    message: $(upper hello)",
        "    children:",
        "    - log: {message: child}",
        "- twice: {message: no, children: [], if: 'false'}",
    )
    assert [message for _, _, message in done.start.messages] == ["child", "HELLO", "HELLO"]


def test_a_strangers_action_is_a_tag_in_xml(plan):
    twice = "<launch><twice message='$(upper hello)'><log message='child'/></twice></launch>"
    done = plan(twice, name="file.launch.xml")
    assert [message for _, _, message in done.start.messages] == ["child", "HELLO", "HELLO"]
    with pytest.raises(LaunchError, match="unknown attribute 'mesage'"):
        plan("<launch><twice mesage='x'/></launch>", name="file.launch.xml")


@pytest.mark.parametrize(
    ("entry", "error"),
    [
        ("twice: {children: []}", "'message' is missing"),
        ("twice: {mesage: x, children: []}", "unknown key 'mesage'"),
        ("twice: {message: explode, children: []}", "Twice failed: ZeroDivisionError"),
        ("gone: {}", "launch action 'gone' of strange-launch: .* cannot be imported"),
        ("log: {message: $(upper)}", "expected 1 argument"),
        ("log: {message: $(uper x)}", "unknown substitution 'uper'"),
        ("log: {message: $(bad x)}", r"\$\(bad x\): IndexError"),
        ("log: {message: $(unlike x)}", "is not an object of .*Substitution"),
    ],
)
def test_what_goes_wrong_in_a_strangers_is_told_with_file_and_line(plan, tmp_path, entry, error):
    with pytest.raises(Exception, match=error) as told:
        plan("- log: {message: first}", f"- {entry}")
    assert str(told.value).startswith(f"{tmp_path / 'file.yaml'}:3:")


def test_the_actions_of_strangers_are_listed_with_ours(plan):
    with pytest.raises(LaunchError, match=r"expected one of append_env, .*gone, .*twice"):
        plan("- twise: {}")


def test_a_file_in_a_strangers_language_is_included_as_any_other(plan, tmp_path):
    (tmp_path / "other.strange").write_text("whatever")
    done = plan("- include: {file: other.strange}")
    assert [message for _, _, message in done.start.messages] == ["read"]
    assert find_launch_file(None, str(tmp_path / "other.strange")).name == "other.strange"
