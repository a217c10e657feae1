"""Launch files that do not follow the vocabulary: where, what, and what was expected."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import TeleopctlError
from teleopctl.launch.frontends.yaml_file import parse_file


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "file.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("text", "line", "expected"),
    [
        ("nodes: []", 1, "expected a mapping with the key 'launch'"),
        ("", 1, "expected a mapping with the key 'launch', got nothing"),
        ("launch: 3", 1, "'launch': expected a list of actions, got 3"),
        ("launch:\n- nod: {}", 2, "unknown action 'nod', expected one of"),
        ("launch:\n- node:\n    pkg: a\n    exce: b", 4, "unknown key 'exce', expected one of"),
        ("launch:\n- node:\n    pkg: a", 3, "'exec' is missing"),
        (
            "launch:\n- node: {pkg: a, exec: b, param: 3}",
            2,
            "expected a list of 'name: …, value: …'",
        ),
        ("launch:\n- node:\n  pkg: a", 2, "expected one action, got a mapping with node, pkg"),
        ("launch:\n- let: {name: a, value: '$(var x'}", 2, "has no closing '\\)'"),
        ("launch:\n- let: {name: a, name: b}", 2, "is given twice"),
        ("launch:\n- let: {a: [}", 2, "not YAML"),
        ("launch:\n- group: {children: [], scoped: maybe}", 2, "expected true or false"),
        ("launch:\n- let: {name: a, value: !!int x}", 2, "not YAML: 'x' is no !!int"),
        ("launch:\n- node_container: {}", 2, "'name' is missing"),
        ("launch:\n- node: {pkg: a, exec: b, on_exit: explode}", 2, "expected 'shutdown'"),
    ],
)
def test_errors_name_file_line_and_what_was_expected(write, text, line, expected):
    path = write(text)
    with pytest.raises(TeleopctlError, match=expected) as caught:
        parse_file(path)
    assert caught.value.message.startswith(f"{path}:{line}:")


def test_a_misspelled_key_has_a_suggestion(write):
    with pytest.raises(TeleopctlError) as caught:
        parse_file(write("launch:\n- node: {pkg: a, exec: b, namspace: c}"))
    assert "namespace" in str(caught.value.hint)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(TeleopctlError, match=r"Cannot read .*nope\.yaml: No such file"):
        parse_file(tmp_path / "nope.yaml")


def test_names_with_hyphens_and_underscores_are_the_same(write):
    text = (
        "launch:\n- push-ros-namespace: {namespace: a}\n- node: {pkg: a, exec: b, launch_prefix: c}"
    )
    assert len(parse_file(write(text)).steps) == 2


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda children: (
        st.lists(children, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["node", "group", "pkg", "exec", "param", "name", "value", "let", "if"]
            ),
            children,
            max_size=3,
        )
    ),
    max_leaves=8,
)


@given(values)
def test_any_yaml_is_read_or_refused(tmp_path_factory, value):
    import json

    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(json.dumps({"launch": value}, ensure_ascii=False), encoding="utf-8")
    try:
        parse_file(path)
    except TeleopctlError as error:
        assert str(path) in error.message
