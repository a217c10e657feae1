"""The grammar of substitutions."""

import pytest
from hypothesis import given, strategies as st

from teleopctl.launch.model.template import Call, ComputedText, TemplateError, literal, parse


def show(call: Call | ComputedText) -> str:
    assert isinstance(call, Call)
    words = [f"<{argument.template.render(show)}>" for argument in call.arguments]
    return f"[{' '.join([call.name, *words])}]"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain text", "plain text"),
        ("", ""),
        ("$(var x)", "[var <x>]"),
        ("a$(var x)b$(dirname)c", "a[var <x>]b[dirname]c"),
        ("$( env  HOME   fallback )", "[env <HOME> <fallback>]"),
        ("$(var 'two words')", "[var <two words>]"),
        ('$(var "two words")', "[var <two words>]"),
        ("$(find-pkg-share $(var pkg))/urdf", "[find-pkg-share <[var <pkg>]>]/urdf"),
        ("$(eval (1 + 2) * 3)", "[eval <(1 + 2)> <*> <3>]"),
        ("$(command 'xacro $(var model)')", "[command <xacro [var <model>]>]"),
        ("""$(eval "'$(var a)' == 'b'")""", "[eval <'[var <a>]' == 'b'>]"),
        (r"\$(var x)", "$(var x)"),
        (r"$(var 'it\'s')", "[var <it's>]"),
        (r"C:\robots\arm", r"C:\robots\arm"),
        ("costs 5$ each", "costs 5$ each"),
        ("'quotes' outside \"stay\"", "'quotes' outside \"stay\""),
        ("$(xacro f.xacro a:=1 'b:=2 3')", "[xacro <f.xacro> <a:=1> <b:=2 3>]"),
    ],
)
def test_texts_are_split_into_substitutions(text, expected):
    assert parse(text).render(show) == expected


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("$(var x", "no closing '\\)'"),
        ("$(", "no name"),
        ("$()", "no name"),
        ("$(var 'x)", "no closing '"),
        ("$(var 'x'y)", "expected a blank or '\\)'"),
    ],
)
def test_malformed_substitutions_say_what_is_missing(text, reason):
    with pytest.raises(TemplateError, match=reason):
        parse(text)


@given(st.text())
def test_a_literal_stands_for_itself(text):
    assert literal(text).render(show) == text


@given(st.text())
def test_any_text_is_parsed_or_refused(text):
    try:
        parse(text).render(show)
    except TemplateError:
        assert "$(" in text


@given(st.text(alphabet=st.characters(exclude_characters="\\$'\"()", codec="utf-8")))
def test_a_quoted_argument_keeps_its_text(text):
    assert parse(f"$(var '{text}')").render(show) == f"[var <{text}>]"
