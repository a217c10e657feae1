"""The programs of docs/testing.md, each run as it stands there."""

import re

import pytest

from tests import ROOT

TEXT = (ROOT / "docs" / "testing.md").read_text(encoding="utf-8")
PROGRAMS = dict(re.findall(r"```python\n# (\S+)\n(.*?)```", TEXT, re.DOTALL))


@pytest.fixture(params=PROGRAMS)
def program(request, ros_without_router):
    (ros_without_router.folder / request.param).write_text(PROGRAMS[request.param])
    return request.param


def test_it_runs_and_is_short(program, ros_without_router):
    assert PROGRAMS[program].count("\n") < 30
    if program.startswith("test_"):
        ros_without_router.env["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
        argv = ["pytest", ["-p", "teleopctl.testing.pytest_plugin", "-q", program]]
    else:
        argv = [program.removesuffix(".py"), []]
    done = ros_without_router.run_module(*argv, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 passed" in done.stdout or "/robot_state_publisher" in done.stdout


def test_each_fixture_that_the_page_names_is_one_of_the_plug_in(ros_without_router):
    named = set(re.findall(r"^\| `(\w+)` \|", TEXT, re.MULTILINE))
    ros_without_router.env["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    listing = ros_without_router.run_module(
        "pytest", ["-p", "teleopctl.testing.pytest_plugin", "--fixtures", "-q"]
    ).stdout
    section = listing.partition("teleopctl.testing.pytest_plugin")[2]
    assert set(re.findall(r"^(\w+)(?: \[\w+ scope\])? -- ", section, re.MULTILINE)) == named
