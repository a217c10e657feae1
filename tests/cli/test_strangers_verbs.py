"""Verbs of other distributions, and verbs of ros2 that teleopctl does not have."""

import subprocess
import sys

import pytest

from teleopctl import plugins
from teleopctl.cli import main
from tests.distributions import install

GREETER = '''
    from typing import Annotated

    from teleopctl.cli import console
    from teleopctl.cli.verb import Argument, Verb, VerbGroup

    def greet(who: Annotated[str, Argument(help="Whom.", complete="greeter:people")]) -> None:
        """Say hello."""
        console.out(f"Hello {who}")

    def people(incomplete: str) -> list[str]:
        return [name for name in ("Ada", "Alan", "Grace") if name.startswith(incomplete)]

    VERB = Verb("greeter:greet", "Greet somebody.")
    GROUP = VerbGroup("Greet many.", {"one": VERB})
'''

OLD_SCRIPT = """
    '''Drive until the end.'''
    raise SystemExit("it drives")
"""


@pytest.fixture
def site(ros_without_router, tmp_path):
    ros_without_router.env["PYTHONPATH"] = str(tmp_path / "site")
    return tmp_path / "site"


@pytest.fixture
def greeter(site):
    verbs = {"greet": "greeter:VERB", "greetings": "greeter:GROUP", "gone": "no_such_module:VERB"}
    nodes = {"scripts/old": "old_script:main", "scripts/lost": "no_such_script:main"}
    install(
        site,
        "my-greeter",
        {"teleopctl.verbs": verbs, "teleopctl.nodes": nodes},
        {"greeter.py": GREETER, "old_script.py": OLD_SCRIPT},
    )


def test_a_strangers_verb_runs_as_ours_do(ros_without_router, greeter):
    ros = ros_without_router
    for line in ("greet Ada", "greetings one Ada", "greet -- Ada"):
        done = ros.run(line)
        assert (done.returncode, done.stdout, done.stderr) == (0, "Hello Ada\n", "")
    assert "Whom." in ros.run("greet --help").stdout
    assert ros.run("greet").returncode == 2


def test_help_names_the_distribution_of_a_strangers_verb(ros_without_router, greeter):
    done = ros_without_router.run("--help")
    listing = " ".join(done.stdout.split())
    assert "greet Greet somebody. (from my-greeter)" in listing
    assert "greetings Greet many. (from my-greeter)" in listing
    assert "gone Cannot be loaded. (from my-greeter)" in listing
    assert "topic List, print, measure and publish topics." in listing
    assert (done.returncode, done.stderr) == (0, "")


def test_a_broken_verb_is_one_line_of_its_own_use(ros_without_router, greeter):
    done = ros_without_router.run("gone")
    assert done.returncode == 1
    assert done.stderr == (
        "teleopctl: verb 'gone' of my-greeter: no_such_module:VERB cannot be imported: "
        "ModuleNotFoundError: No module named 'no_such_module'\n"
    )


def test_extensions_are_listed_with_who_brings_them_and_why_they_cannot_be_loaded(
    ros_without_router, greeter
):
    ros = ros_without_router
    listed = ros.run("extensions -v").stdout
    verbs = listed.partition("\nteleopctl.verbs\n")[2]
    assert "  greet: Greet somebody.\n    module_name: greeter\n    attributes: VERB\n" in verbs
    assert "    distribution: my-greeter " in verbs
    assert "  topic: List, print, measure and publish topics.\n" in verbs
    assert "gone" not in verbs
    assert "  scripts/old: Drive until the end.\n" in listed
    assert "scripts/lost" not in listed
    broken = ros.run("extensions -a").stdout
    assert "- gone: \n-   reason: verb 'gone' of my-greeter: no_such_module:VERB cannot" in broken
    points = ros.run("extension_points --verbose").stdout
    assert "teleopctl.verbs: verb\n    module_name: teleopctl.cli.verb\n" in points


def test_plugins_are_listed_by_package_with_their_classes(ros_without_router, site):
    ros = ros_without_router
    install(site, "my-arms", {"teleopctl.controllers": {"arms/Mine": "arms:Mine"}}, {})
    base = "teleopctl.control.controllers.base.ControllerInterface"
    mine = f"arms:\n\tarms/Mine [arms.Mine] (base: {base})\n"
    assert mine in ros.run("plugin list").stdout
    assert ros.run("plugin list --package arms").stdout == mine
    assert "arms" in ros.run("plugin list --packages").stdout.splitlines()
    unknown = ros.run("plugin list --package arm")
    assert (unknown.returncode, unknown.stdout) == (1, "")
    assert "Package 'arm' has no plug-ins\n  Did you mean" in unknown.stderr


def test_a_strangers_verb_and_its_arguments_are_completed(ros_without_router, greeter):
    ros_without_router.env["_TELEOPCTL_COMPLETE"] = "zsh"

    def offered(line):
        done = ros_without_router.run(["--", *line.split(" ")])
        assert done.stderr == ""
        return done.stdout.split()

    assert offered("gre") == ["greet", "greetings"]
    assert offered("greetings o") == ["one"]
    assert offered("greet A") == ["Ada", "Alan"]
    assert offered("gone ") == []


def test_a_command_of_ours_reads_no_entry_points(ros, tmp_path):
    probe = (
        "import sys; from teleopctl.cli import main; main.run(['topic', 'list']); "
        "print('importlib.metadata' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", probe], env=ros.env, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.splitlines()[-1] == "False", done.stderr


@pytest.mark.parametrize(
    ("line", "verb", "where"),
    [
        ("security", "security", "teleopctl"),
        ("security --help", "security", "teleopctl"),
        ("security create_keystore here", "security", "teleopctl"),
    ],
)
def test_a_verb_of_ros2_that_is_missing_is_called_missing(capsys, line, verb, where):
    assert main.run(line.split()) == 2
    assert capsys.readouterr().err == (
        f"teleopctl: '{verb}' is a verb of ros2 that teleopctl does not support yet\n"
        f"  See `{where} --help` for those that it has.\n"
    )


@pytest.mark.parametrize("line", ["acton list", "topic lst", "service inf"])
def test_a_misspelt_verb_is_not_called_missing(capsys, line):
    assert main.run(line.split()) == 2
    assert "ros2" not in capsys.readouterr().err


def test_a_missing_verb_that_a_stranger_brings_is_there(ros_without_router, site):
    install(
        site,
        "my-parts",
        {"teleopctl.verbs": {"security": "greeter:VERB"}},
        {"greeter.py": GREETER},
    )
    done = ros_without_router.run("security Ada")
    assert done.stdout == "Hello Ada\n", done.stderr


def test_every_verb_has_a_line_for_help():
    assert set(plugins.VERBS.builtin) == set(plugins.VERBS.summaries)
