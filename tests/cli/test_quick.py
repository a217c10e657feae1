"""The quick parser reads what it accepts exactly as Typer does."""

from typing import Annotated, Any

import pytest
import typer
from hypothesis import given, strategies as st
from typer.main import get_command

from teleopctl.cli import quick, typer_app
from teleopctl.cli.typer_line import typer_line
from teleopctl.cli.verb import Argument, Option, Verb

seen: list[dict[str, object]] = []


def sample(
    name: Annotated[str, Argument(help="A name.")],
    value: Annotated[str | None, Argument(help="A value.")] = None,
    verbose: Annotated[bool, Option("-v", "--verbose", help="A flag.")] = False,
    count: Annotated[bool, Option("-c", help="Another flag.")] = False,
    rate: Annotated[float, Option("-r", "--rate", help="A number.")] = 1.0,
    times: Annotated[int | None, Option("-t", "--times", help="An integer.")] = None,
    field: Annotated[str | None, Option("--field", help="A text.")] = None,
    policy: Annotated[
        str | None, Option("--policy", help="A choice.", choices=("reliable", "best_effort"))
    ] = None,
) -> None:
    seen.append(dict(locals()))


def many(names: Annotated[list[str], Argument(help="Names.")]) -> None:
    seen.append(dict(locals()))


def several(names: Annotated[list[str] | None, Argument(help="Names.")] = None) -> None:
    seen.append(dict(locals()))


def chosen(state: Annotated[str, Argument(help="A choice.", choices=("on", "off"))]) -> None:
    seen.append(dict(locals()))


def writing(
    bag: Annotated[str, Argument(help="A name.")],
    output: Annotated[str, Option("-o", help="A text that has to be given.")],
) -> None:
    seen.append(dict(locals()))


def fields(
    topic: Annotated[str, Argument(help="A name.")],
    field: Annotated[list[str] | None, Option("--field", help="Texts.", repeated=True)] = None,
) -> None:
    seen.append(dict(locals()))


def switching(
    manager: Annotated[str | None, Argument(help="A name.")] = None,
    stop: Annotated[list[str] | None, Option("--stop", help="Names.")] = None,
    start: Annotated[list[str] | None, Option("-s", "--start", help="Names.")] = None,
    strict: Annotated[bool, Option("--strict", help="A flag.")] = False,
) -> None:
    seen.append(dict(locals()))


def remapped(
    name: Annotated[str, Argument(help="A name.")],
    verbose: Annotated[bool, Option("-v", help="A flag.")] = False,
    ros_args: Annotated[
        list[str] | None, Option("--ros-args", help="All that follows.", rest=True)
    ] = None,
) -> None:
    seen.append(dict(locals()))


def program(
    words: Annotated[list[str], Argument(help="A program and its arguments.")],
    detach: Annotated[bool, Option("-d", help="A flag.")] = False,
) -> None:
    seen.append(dict(locals()))


def verb_of(function, **options):
    return Verb(f"{__name__}:{function.__name__}", "help", **options)


def quick_reading(function, words, **options):
    return quick.parse(verb_of(function, **options), function, words)


def typer_reading(function, words, **options):
    """What Typer hands to the function, or None where it refuses the line."""
    verb = verb_of(function, **options)
    app = typer.Typer(add_completion=False)
    typer_app._add_verb(app, "sample", verb, typer_app._typer_function(verb))
    seen.clear()
    try:
        command: Any = get_command(app)
        with command.make_context("sample", typer_line(command, words)) as context:
            context.command.invoke(context)
    except (typer.TyperException, typer.Exit):
        return None
    return seen[0]


OPTIONS = "-v --verbose -r --rate -t --times --field --policy -vv -cv -vt -- -"
OPTIONS += " --rate=2 --field=x=y --times=x -r2 --policy=reliable --unknown"
VALUES = ["/chatter", "2", "2.5", "reliable", "x", "", "1_0", "nan", "-1", "-2.5", "{data: 1}", "²"]
WORDS = st.lists(st.sampled_from([*OPTIONS.split(), *VALUES]), max_size=6)


@given(WORDS, st.booleans())
def test_what_it_accepts_typer_reads_alike(words, negative_numbers):
    values = quick_reading(sample, words, negative_numbers=negative_numbers)
    if values is not None:
        assert values == typer_reading(sample, words, negative_numbers=negative_numbers)


@given(st.lists(st.sampled_from(["-d", "-x", "--ros-args", "a", "-1", "--"]), max_size=5))
def test_what_it_passes_on_typer_passes_on_alike(words):
    values = quick_reading(program, words, passes_on=True)
    if values is not None:
        assert values == typer_reading(program, words, passes_on=True)


@given(st.lists(st.sampled_from(["-d", "-x", "--help", "a", "-1", "--", ""]), max_size=5))
def test_a_verb_that_passes_everything_on_sees_every_word(words):
    values = quick_reading(several, words, passes_everything_on=True)
    assert values == (None if words[:1] == ["--help"] else {"names": words or None})


def test_options_behind_the_first_argument_are_passed_on():
    line = ["-d", "talker", "--ros-args", "-p", "rate:=5", "-d"]
    assert quick_reading(program, line, passes_on=True) == {"detach": True, "words": line[1:]}


@pytest.mark.parametrize(
    ("words", "changed"),
    [
        (["/a"], {}),
        (["/a", "-vc"], {"verbose": True, "count": True}),
        (["/a", "-v", "--rate", "5"], {"verbose": True, "rate": 5.0}),
        (["--times=3", "/a", "{data: 1}"], {"times": 3, "value": "{data: 1}"}),
        (["/a", "--policy", "best_effort"], {"policy": "best_effort"}),
    ],
)
def test_well_formed_lines_need_no_typer(words, changed):
    expected = {"name": "/a", "value": None, "verbose": False, "rate": 1.0, "times": None}
    expected |= {"count": False, "field": None, "policy": None}
    assert quick_reading(sample, words) == expected | changed


@pytest.mark.parametrize("line", ["a --rate nan", "a -r inf", "a --rate=-inf"])
def test_a_number_is_finite(line):
    assert quick_reading(sample, line.split()) is None is typer_reading(sample, line.split())


@pytest.mark.parametrize(
    "line",
    ["", "a b c", "a --help", "a --rate", "a --times 1.5", "a --policy loud", "a -1", "a -v=1"],
)
def test_it_leaves_mistakes_to_typer(line):
    assert quick_reading(sample, line.split()) is None


def test_a_list_takes_all_that_is_left():
    names = ["a", "b"]
    assert quick_reading(many, names) == {"names": names} == typer_reading(many, names)
    assert quick_reading(many, []) is None


def test_a_list_may_be_left_out_where_its_default_is_none():
    assert quick_reading(several, ["a"]) == {"names": ["a"]} == typer_reading(several, ["a"])
    assert quick_reading(several, []) == {"names": None} == typer_reading(several, [])


def test_an_argument_with_choices_takes_no_other():
    assert quick_reading(chosen, ["on"]) == {"state": "on"} == typer_reading(chosen, ["on"])
    assert quick_reading(chosen, ["of"]) is None is typer_reading(chosen, ["of"])


def test_each_value_of_a_repeated_option_has_its_name():
    words = ["--field", "a", "/topic", "--field=b"]
    expected = {"topic": "/topic", "field": ["a", "b"]}
    assert quick_reading(fields, words) == expected == typer_reading(fields, words)


def test_an_option_takes_all_words_up_to_the_next_one():
    words = ["m", "--stop", "a", "b", "--strict", "-s", "c", "--stop", "d"]
    expected = {"manager": "m", "stop": ["a", "b", "d"], "start": ["c"], "strict": True}
    assert quick_reading(switching, words) == expected == typer_reading(switching, words)


@given(
    st.lists(
        st.sampled_from(["--stop", "--start", "-s", "--strict", "--stop=a", "--", "-1", "a", "b"]),
        max_size=6,
    ),
    st.booleans(),
)
def test_values_of_options_that_take_several_are_those_that_typer_reads(words, negative_numbers):
    values = quick_reading(switching, words, negative_numbers=negative_numbers)
    if values is not None:
        assert values == typer_reading(switching, words, negative_numbers=negative_numbers)


def test_the_rest_of_a_line_belongs_to_the_option_that_takes_it():
    words = ["a", "--ros-args", "-r", "x:=y", "-v", "--"]
    expected = {"name": "a", "verbose": False, "ros_args": words[2:]}
    assert quick_reading(remapped, words) == expected
    assert quick_reading(remapped, ["a", "-v"]) == {**expected, "verbose": True, "ros_args": None}
    assert quick_reading(remapped, ["--ros-args", "a"]) is None


def test_negative_numbers_are_values_where_the_verb_says_so():
    assert quick_reading(sample, ["a", "-1"], negative_numbers=True)["value"] == "-1"


def test_a_line_without_an_option_that_has_to_be_given_is_left_to_typer():
    assert quick_reading(writing, ["bag"]) is None
    assert typer_reading(writing, ["bag"]) is None
    assert quick_reading(writing, ["bag", "-o", "out"]) == {"bag": "bag", "output": "out"}
