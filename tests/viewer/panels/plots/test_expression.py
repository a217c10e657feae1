"""Expressions of plotted fields: arithmetic on arrays, and nothing else."""

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.viewer.panels.plots.expression import (
    DerivedSamples,
    PlotExpression,
    PlotExpressionError,
    topic_and_path,
)
from teleopctl.viewer.panels.plots.series import Series

TIMES = np.array([0.0, 1.0, 3.0])
VALUES = {"/a/x": np.array([1.0, 2.0, 4.0]), "/b/c/y[1]/z": np.array([0.0, 10.0, 20.0])}


@pytest.mark.parametrize(
    ("text", "fields", "values"),
    [
        ("/a/x", ["/a/x"], [1, 2, 4]),
        ("/b/c/y[1]/z - 2*/a/x", ["/b/c/y[1]/z", "/a/x"], [-2, 6, 12]),
        ("(/a/x) / /b/c/y[1]/z", ["/a/x", "/b/c/y[1]/z"], [np.inf, 0.2, 0.2]),
        ("/a/x / 2 + /a/x", ["/a/x"], [1.5, 3, 6]),
        ("d(/a/x)", ["/a/x"], [1, 1, 1]),
        ("integral(/a/x)", ["/a/x"], [0, 1.5, 7.5]),
        ("sqrt(-/a/x) * 0 + 1", ["/a/x"], [np.nan, np.nan, np.nan]),
        ("max(/a/x, 2) ** 2 % 3", ["/a/x"], [1, 1, 1]),
        ("hypot(/a/x, 0) - pi * 0", ["/a/x"], [1, 2, 4]),
    ],
)
def test_an_expression_is_evaluated_at_all_times(text, fields, values):
    expression = PlotExpression(text)
    assert [*expression.fields] == fields
    assert expression.is_field == (text in fields)
    assert expression.evaluate(TIMES, VALUES) == pytest.approx(values, nan_ok=True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no expression"),
        ("2 + 3", "has no field"),
        ("/a/x +", "is no expression"),
        ("dd(/a/x)", "unknown function dd; did you mean d?"),
        ("/a/x + y", "unknown name y"),
        ("max(/a/x)", "gives max not 2 arguments"),
        ("__import__('os')(/a/x)", "more than numbers"),
        ("/a/x.shape", "more than numbers"),
        ("[/a/x]", "more than numbers"),
        ("/a/x if 1 else 2", "more than numbers"),
        ("(" * 300 + "/a/x" + ")" * 300, "is no expression"),
        ("/a/x " + "+ 1" * 400, "longer than"),
    ],
)
def test_what_is_no_expression_is_refused_with_its_text(text, words):
    with pytest.raises(PlotExpressionError, match=words.replace("?", r"\?")):
        PlotExpression(text)


@given(strategies.text("/ab[]0. +-*()d", max_size=30))
def test_any_text_is_an_expression_or_refused(text):
    try:
        expression = PlotExpression(text)
    except PlotExpressionError:
        return
    values = {field: np.ones(3) for field in expression.fields}
    assert expression.evaluate(TIMES, values).shape == (3,)


def test_the_longest_topic_that_fits_has_the_field():
    topics = ["/a", "/a/b", "/ab"]
    assert topic_and_path("/a/b/c/d[2]/e", topics) == ("/a/b", "c.d[2].e")
    assert topic_and_path("/ab/c", topics) == ("/ab", "c")
    assert topic_and_path("/b/c", topics) is None


def test_samples_are_evaluated_where_all_fields_have_some():
    one, two = Series(), Series()
    for time_s in range(5):
        one.add(float(time_s), float(time_s))
    derived = DerivedSamples(PlotExpression("/a/x + /b/x"), [one, two])
    assert derived.last_s is None
    assert len(derived.between(0, 9)[0]) == 0
    two.add(1.5, 10.0)
    two.add(3.5, 30.0)
    times, values = derived.between(0, 9)
    assert times.tolist() == [1.5, 2, 3, 3.5]
    assert values.tolist() == [11.5, 17, 28, 33.5]
    assert [derived.first_s, derived.last_s, derived.added] == [1.5, 3.5, 7]
