"""The languages of launch files say the same: one description, written in each, is one plan."""

import json
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file


@dataclass
class Entry:
    """An action or what belongs to one, in no language.

    Attributes:
        name: Action, or key of the list that it is in.
        texts: Keys with one text each, or a flag.
        value: A parameter's value, which has a type.
        nested: Entries in lists, by their names.
        children: Actions in it, or None.
    """

    name: str
    texts: dict[str, str | bool] = field(default_factory=dict)
    value: object = None
    nested: list["Entry"] = field(default_factory=list)
    children: list["Entry"] | None = None


def as_yaml(entry):
    content = dict(entry.texts)
    if entry.value is not None:
        content["value"] = entry.value
    for nested in entry.nested:
        content.setdefault(nested.name, []).append(as_yaml(nested))
    if entry.children is not None:
        content["children"] = [{child.name: as_yaml(child)} for child in entry.children]
    return content


def as_xml(entry):
    attributes = {
        key: value if isinstance(value, str) else json.dumps(value)
        for key, value in entry.texts.items()
    }
    if entry.value is not None:
        attributes["value"] = json.dumps(entry.value, ensure_ascii=False)
    tag = ET.Element(entry.name, attributes)
    tag.extend(map(as_xml, (*entry.nested, *(entry.children or ()))))
    return tag


words = st.text("ab1 .,:#[]{}&<>ä-", min_size=1, max_size=6)
names = st.sampled_from(["a", "b", "long_name"])
texts = words | st.builds("{}$(var a){}".format, words, words)
scalars = st.booleans() | st.integers(-(2**60), 2**60) | st.floats(-1e9, 1e9) | texts
lists = st.sampled_from(
    [st.booleans(), st.integers(-9, 9), st.floats(-9, 9), words],
).flatmap(lambda kind: st.lists(kind, min_size=1, max_size=3))


def entry(name, texts, **others):
    return st.builds(Entry, st.just(name), texts, **others)


def keys(required, optional=None):
    return st.fixed_dictionaries(required, optional=optional or {})


conditions = {"if": st.sampled_from(["true", "1", "0", "$(eval 1 > 2)"])}
flags = st.sampled_from(["true", "false"])
pair_texts = {"name": names, "value": texts}
pair = keys(pair_texts)
parameters = entry("param", keys({"name": names}), value=scalars | lists)
groups = entry("param", keys({"name": names}), nested=st.lists(parameters, min_size=1, max_size=2))
node_lists = st.one_of(
    parameters,
    groups,
    entry("remap", keys({"from": names, "to": texts})),
    entry("env", pair),
)
settings = st.one_of(
    entry("let", pair),
    entry("set_env", pair),
    entry("set-env", pair),
    entry("arg", keys({"name": names, "default": texts}, conditions)),
    entry("set_remap", keys({"from": names, "to": texts})),
    entry("set_parameter", keys({"name": names}), value=scalars | lists),
    entry("push_ros_namespace", keys({"namespace": names})),
    entry("reset", keys({}), nested=st.lists(entry("keep", pair), max_size=2)),
    entry("append_env", keys(pair_texts, {"separator": words, "prepend": flags})),
    entry("log", keys({"message": texts}, conditions)),
    entry("log_error", keys({"message": texts})),
)
processes = st.one_of(
    entry(
        "executable",
        keys(
            {"cmd": st.sampled_from(["echo $(var a)", "ls -l"])},
            {"shell": flags, "output": st.just("screen")},
        ),
        nested=st.lists(entry("env", pair), max_size=2),
    ),
    entry(
        "node",
        keys(
            {"pkg": st.just("camera"), "exec": st.just("camera")},
            {
                **conditions,
                "name": names,
                "namespace": names,
                "launch-prefix": st.just("nice -n 1"),
                "respawn": flags,
                "respawn_delay": st.sampled_from(["1", "2.5"]),
                "on_exit": st.just("shutdown"),
                "ros_args": st.just("--log-level debug"),
            },
        ),
        nested=st.lists(node_lists, max_size=4),
    ),
)
actions = st.recursive(
    settings | processes,
    lambda inner: st.one_of(
        entry(
            "group",
            keys({}, {"scoped": st.booleans(), "forwarding": st.booleans(), **conditions}),
            nested=st.lists(entry("keep", pair), max_size=1),
            children=st.lists(inner, max_size=4),
        ),
        entry(
            "for",
            keys({"len": st.sampled_from(["0", "2"]), "name": names}),
            children=st.lists(inner, max_size=2),
        ),
        entry(
            "timer",
            keys({"period": st.sampled_from(["1", "0.5"])}),
            children=st.lists(inner, max_size=3),
        ),
    ),
    max_leaves=8,
)


def done(further):
    return further.messages, further.files, further.processes, further.shutdown


def foretold(dry_run):
    return [(one.when, done(one.follow_up), foretold(one.then)) for one in dry_run]


def result(path):
    try:
        plan, evaluation = evaluate(read_launch_file(path), {}, Path("log"))
        return done(plan.start), plan.warnings, foretold(evaluation.dry_run(plan.start))
    except TeleopctlError as error:
        return error.message.rpartition(f"{path}:")[2].partition(":")[2]


@given(st.lists(actions, max_size=5))
def test_a_description_is_the_same_plan_in_yaml_and_in_xml(tmp_path_factory, entries):
    folder = tmp_path_factory.getbasetemp()
    description = [Entry("let", {"name": "a", "value": "x"}), *entries]
    in_yaml, in_xml = folder / "same.launch.yaml", folder / "same.launch.xml"
    in_yaml.write_text(
        yaml.safe_dump({"launch": [{one.name: as_yaml(one)} for one in description]}),
        encoding="utf-8",
    )
    root = ET.Element("launch", version="0.1.1")
    root.extend(map(as_xml, description))
    in_xml.write_bytes(ET.tostring(root, encoding="utf-8"))
    assert result(in_yaml) == result(in_xml)
