"""``--help``: complete, made of the declarations, and without loading what it describes."""

import json
import os
import re
import subprocess
import sys
from typing import Annotated

import pytest

from teleopctl import plugins
from teleopctl.cli import console, declared, help_page, main
from teleopctl.cli.declared import DeclaredVerb
from teleopctl.cli.verb import Argument, Option, Verb, parameters
from tests.cli.verb_paths import groups, verbs
from tests.distributions import install
from tests.samples import sample

ALL = verbs()


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A folder of nobody else's, in which nothing is remembered."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("COLUMNS", raising=False)
    return tmp_path / "cache"


def page(capsys, *words: str) -> str:
    assert main.run([*words, "--help"]) == 0
    return str(capsys.readouterr().out)


@pytest.mark.parametrize("line", ["", "--help", "-h"])
def test_the_programs_page_lists_every_verb(capsys, line):
    assert main.run(line.split()) == 0
    listing = capsys.readouterr().out
    assert {*plugins.VERBS.summaries} <= {*re.findall(r"\w+", listing)}
    grouped = [name for names in help_page.PURPOSES.values() for name in names]
    for verb in grouped:
        assert f"  {verb} " in listing
        assert plugins.VERBS.summaries[verb] in listing
    # The last ones are those that few people need.
    assert (
        " ".join(listing.split())
        .partition(" multicast ")[0]
        .endswith("wtf, extensions, extension_points,")
    )
    assert len(listing.splitlines()) <= 40, "one screen"


@pytest.mark.parametrize("noun", groups())
def test_a_nouns_page_lists_its_verbs(capsys, noun):
    text = " ".join(page(capsys, noun).split())
    for name, verb in groups()[noun].verbs.items():
        assert f" {name} {verb.help}" in text


@pytest.mark.parametrize("path", sample(ALL, 4), ids=" ".join)
def test_a_verbs_page_has_every_argument_and_option_with_its_text(capsys, path):
    verb = ALL[path]
    text = page(capsys, *path)
    words = " ".join(text.split())
    assert words.startswith(f"Usage: teleopctl {' '.join(path)} [OPTIONS]")
    assert verb.help in words
    for parameter in parameters(verb.load()):
        declaration = parameter.declaration
        assert " ".join(declaration.help.split()) in words
        if isinstance(declaration, Option):
            assert all(f"{flag}" in words.replace(",", "").split() for flag in declaration.flags)
        assert all(choice in words for choice in declaration.choices)
    for example in verb.examples:
        assert f"\n  {example}\n" in text
    usage, _, _ = text.partition("\n\n")
    assert "......" not in usage.replace("]", "")


@pytest.mark.parametrize("path", sample(ALL, 4), ids=" ".join)
def test_what_is_remembered_of_a_verb_is_what_it_declares(cache, path):
    first = declared.find_declaration(path)
    assert isinstance(first, DeclaredVerb)
    (file,) = cache.rglob(f"verb.{'.'.join(path)}")
    again = declared.find_declaration(path)
    assert isinstance(again, DeclaredVerb)
    assert declared._to_plain(again) == declared._to_plain(first)
    written = {slot: getattr(first.verb, slot) for slot in Verb.__slots__}
    assert {slot: getattr(again.verb, slot) for slot in Verb.__slots__} == written
    file.write_bytes(file.read_bytes()[:-9])
    assert help_page.page_text(path, first) == help_page.page_text(path, again)
    assert declared.find_declaration(path) is not None, "a file that was cut short"


def test_help_prints_the_page_of_its_words_and_names_a_near_verb(capsys):
    assert main.run(["help", "topic", "echo"]) == 0
    assert capsys.readouterr().out == page(capsys, "topic", "echo")
    assert main.run(["help", "topic"]) == 0
    assert capsys.readouterr().out == page(capsys, "topic")
    assert main.run(["help"]) == 0
    assert capsys.readouterr().out == page(capsys)
    assert main.run(["help", "topic", "ecco"]) == 2
    assert capsys.readouterr().err == (
        "teleopctl: No such command 'ecco'\n  Did you mean echo? See `teleopctl topic --help`.\n"
    )


def test_a_noun_that_stands_alone_shows_the_options_of_its_verb(capsys):
    text = page(capsys, "doctor")
    assert "-r, --report " in text
    assert "-ep, --exclude-packages " in text
    assert "\n  hello " in text


def test_pages_have_the_name_by_which_the_program_was_started(capsys, monkeypatch):
    monkeypatch.setattr(console, "PROGRAM", "ros2")
    monkeypatch.setattr(help_page, "PROGRAM", "ros2")
    text = page(capsys, "topic", "pub")
    assert text.startswith("Usage: ros2 topic pub [OPTIONS]")
    assert "teleopctl" not in text
    console.note("Try `teleopctl doctor`, or teleopctl ps")
    assert capsys.readouterr().err == "Try `ros2 doctor`, or ros2 ps\n"


def test_no_page_loads_a_library_that_parses_or_draws(tmp_path):
    code = (
        "import io, json, sys\nfrom contextlib import redirect_stdout\n"
        "from teleopctl.cli import main\n"
        "lines = json.loads(sys.argv[1])\n"
        "with redirect_stdout(io.StringIO()):\n"
        "    status = {main.run([*line, '--help']) for line in lines}\n"
        "print(json.dumps([sorted(status), sorted(sys.modules)]))"
    )
    lines = json.dumps([[], *([name] for name in groups()), *ALL])

    def loaded() -> set[str]:
        done = subprocess.run(
            [sys.executable, "-c", code, lines],
            env={**os.environ, "XDG_CACHE_HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        status, modules = json.loads(done.stdout)
        assert status == [0]
        return {name.partition(".")[0] for name in modules}

    assert not loaded() & {"typer", "click", "rich"}
    # The second time no verb is loaded either; redirecting and json take some of the rest here.
    assert not loaded() & {"typing", "zenoh", "yaml", "logging", "dataclasses", "pathlib"}


GREETER = '''
    from typing import Annotated
    from teleopctl.cli.verb import Option, Verb

    def greet(loud: Annotated[bool, Option("--loud", help="{text}")] = False) -> None:
        """Say hello."""

    VERB = Verb("greeter:greet", "Greet somebody.")
'''


def test_a_verb_that_has_changed_is_looked_at_again(ros_without_router, tmp_path):
    ros = ros_without_router
    site = tmp_path / "site"
    ros.env["PYTHONPATH"] = str(site)
    verb = {"teleopctl.verbs": {"greet": "greeter:VERB"}}
    assert "greet" not in ros.run("--help").stdout
    install(site, "my-greeter", verb, {"greeter.py": GREETER.format(text="Shout.")})
    for _ in range(2):
        assert "Greet somebody. (from my-greeter)" in ros.run("--help").stdout
        assert "Shout." in ros.run("greet --help").stdout
    (site / "greeter.py").write_text((site / "greeter.py").read_text().replace("Shout", "Bellow"))
    assert "Bellow." in ros.run("greet --help").stdout
    del ros.env["PYTHONPATH"]
    assert "greet" not in ros.run("--help").stdout
    assert ros.run("greet --help").returncode == 2


def test_a_cache_that_cannot_be_written_is_done_without(capsys, cache):
    cache.write_text("a file where the folder should be")
    assert "--field" in page(capsys, "topic", "echo")


def test_the_page_is_as_wide_as_the_terminal_and_not_wider_than_a_book(capsys, monkeypatch):
    for columns, widest in (("60", 60), ("0", 80), ("300", 100)):
        monkeypatch.setenv("COLUMNS", columns)
        text = page(capsys, "topic", "echo").partition("\n")[2].partition("Examples:")[0]
        assert widest - 8 <= max(map(len, text.splitlines())) <= widest


def test_names_have_a_colour_where_colours_are_wanted(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\n  \x1b[36m--once\x1b[0m" in page(capsys, "topic", "echo")
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b" not in page(capsys, "topic", "echo")


def program(
    words: Annotated[list[str], Argument(help="A program and its arguments.")],
    prefix: Annotated[str | None, Option("--prefix", help="A text.")] = None,
) -> None:
    """Run a program."""


@pytest.mark.parametrize(
    ("line", "asks"),
    [
        ("--help", True),
        ("-h", True),
        ("--prefix gdb --help", True),
        ("--prefix --help", False),
        ("talker --help", False),
        ("-- --help", False),
    ],
)
def test_help_behind_a_programs_name_is_the_programs(line, asks):
    verb = Verb(f"{__name__}:program", "Run a program.", passes_on=True)
    found = DeclaredVerb(verb, parameters(program), [])
    assert help_page._asks(found, line.split()) == asks


@pytest.mark.parametrize("line", ["topic echo -h", "topic echo -fh", "topic echo /x --help"])
def test_a_verbs_page_is_one_however_it_is_asked_for(capsys, line):
    assert main.run(line.split()) == 0
    assert capsys.readouterr().out.strip() == page(capsys, "topic", "echo").strip()
