"""Which values the runs of a sweep have."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given, strategies as st

from teleopctl.errors import UsageError
from teleopctl.sweep import combinations, parse_grid, parse_sample


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("mass:=0.5,1, 2", ("0.5", "1", "2")),
        ("pose:=[0,0,1],[1,0,0]", ("[0,0,1]", "[1,0,0]")),
        ("model:=arm.urdf", ("arm.urdf",)),
        ("x:=linspace(0,1,5)", ("0.0", "0.25", "0.5", "0.75", "1.0")),
        ("x:=linspace(-1,1e7,2)", ("-1.0", "1.0e+07")),
        ("x:=linspace(1e6,1000001,3)", ("1.0e+06", "1000000.5", "1000001.0")),
    ],
)
def test_a_grid_has_each_of_its_values(text: str, values: tuple[str, ...]) -> None:
    assert parse_grid(text).values == values


def test_each_combination_of_the_grids_has_the_same_draws() -> None:
    grids = [parse_grid("mass:=1,2"), parse_grid("arm:gains.p:=10,20")]
    samples = [parse_sample("friction:=uniform(0.2,1)")]
    runs = combinations(grids, samples, 3, seed=1)

    assert [(run["mass"], run["arm:gains.p"]) for run in runs[::3]] == [
        ("1", "10"), ("1", "20"), ("2", "10"), ("2", "20"),
    ]  # fmt: skip
    draws = [run["friction"] for run in runs]
    assert draws[:3] * 4 == draws
    assert len(set(draws)) == 3


def test_a_parameter_beside_it_does_not_change_what_is_drawn() -> None:
    friction, seeds = parse_sample("friction:=normal(0.5,0.1)"), parse_sample("n:=integers(1,9)")
    alone = combinations([], [friction], 5, seed=7)
    beside = combinations([parse_grid("x:=1")], [seeds, friction], 5, seed=7)
    other = combinations([], [friction], 5, seed=8)

    assert [run["friction"] for run in beside] == [run["friction"] for run in alone]
    assert [run["friction"] for run in other] != [run["friction"] for run in alone]


@given(
    kind=st.sampled_from(["uniform", "loguniform"]),
    ends=st.tuples(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9)).map(sorted),
    seed=st.integers(0, 100),
)
def test_what_is_drawn_is_within_its_ends_and_a_real_number(
    kind: str, ends: list[float], seed: int
) -> None:
    low, high = ends
    (run,) = combinations([], [parse_sample(f"x:={kind}({low},{high})")], 1, seed)
    value = yaml.safe_load(run["x"])
    assert isinstance(value, float)
    assert low * 0.99999 <= value <= high * 1.00001


@pytest.mark.parametrize(
    ("parse", "text"),
    [
        (parse_grid, "mass"),
        (parse_grid, ":=1,2"),
        (parse_grid, "x:=linspace(0,1)"),
        (parse_grid, "x:=linspace(0,1,1.5)"),
        (parse_sample, "x:=1"),
        (parse_sample, "x:=uniform(1,0)"),
        (parse_sample, "x:=uniform(1)"),
        (parse_sample, "x:=loguniform(0,1)"),
        (parse_sample, "x:=normal(0,nan)"),
        (parse_sample, "x:=integers(0.5,1)"),
        (parse_sample, "x:=poisson(1,2)"),
    ],
)
def test_what_cannot_be_meant_is_refused(parse, text: str) -> None:
    with pytest.raises(UsageError, match=r"'.*'"):
        parse(text)


def test_no_parameter_is_varied_twice() -> None:
    with pytest.raises(UsageError, match="'x' is varied twice"):
        combinations([parse_grid("x:=1")], [parse_sample("x:=choice(a,b)")], 1, 0)
