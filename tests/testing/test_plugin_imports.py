"""The pytest plug-in lets the tests of a project import ``rclpy``, as soon as it is installed."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests import LEAN_PYTEST, ROOT

TEST = """
import rclpy
from std_msgs.msg import String


def test_it():
    assert String(data="x").data == "x"
    assert not rclpy.ok()
"""


@pytest.fixture
def project(tmp_path):
    """A folder with tests, in an environment where the plug-in is known by its entry point."""
    metadata = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    entries = metadata["project"]["entry-points"]["pytest11"]
    installed = tmp_path / "installed"
    distribution = installed / "teleopctl_as_installed-1.dist-info"
    distribution.mkdir(parents=True)
    (distribution / "METADATA").write_text("Metadata-Version: 2.1\nName: teleopctl-as-installed\n")
    lines = [f"{name} = {target}" for name, target in entries.items()]
    (distribution / "entry_points.txt").write_text("\n".join(["[pytest11]", *lines, ""]))
    # pytest asks for a rewrite of all that the distribution of a plug-in lists and that is there.
    (distribution / "RECORD").write_text("teleopctl/__init__.py,,\n")
    (installed / "teleopctl").mkdir()
    (installed / "teleopctl" / "__init__.py").write_text("")
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "pytest.ini").write_text("[pytest]\n")
    (folder / "test_node.py").write_text(TEST)
    return folder


def run_pytest(
    folder: Path, *args: str, python: tuple[str, ...] = ()
) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(ROOT), str(folder.parent / "installed")])
    return subprocess.run(
        [sys.executable, *python, "-m", "pytest", *LEAN_PYTEST, "-p", "no:cacheprovider", *args],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_plain_pytest_finds_rclpy(project):
    done = run_pytest(project)
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout


@pytest.mark.nightly
def test_the_first_conftest_finds_it_already(project):
    (project / "conftest.py").write_text("import rclpy, tf2_ros\n")
    done = run_pytest(project)
    assert done.returncode == 0, done.stderr


@pytest.mark.nightly
def test_a_python_that_has_imported_teleopctl_at_its_start_gives_pytest_no_warning(project):
    (project / "pytest.ini").write_text("[pytest]\nfilterwarnings = error\n")
    done = run_pytest(project, python=("-m", "teleopctl", "python"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 passed" in done.stdout


@pytest.mark.parametrize("args", [["-p", "no:teleopctl"], ["-o", "teleopctl_imports=false"]])
def test_it_can_be_left_out(project, args):
    done = run_pytest(project, *args)
    assert done.returncode == 2
    assert "No module named 'rclpy'" in done.stdout


def test_what_is_really_installed_wins(project):
    (project.parent / "installed" / "rclpy.py").write_text("def ok():\n    return 'the real one'\n")
    done = run_pytest(project)
    assert done.returncode == 1
    assert "the real one" in done.stdout


@pytest.mark.nightly
def test_launch_tests_are_left_to_a_launch_testing_that_is_really_installed(project):
    ours = run_pytest(project, "--launch-args", "rate:=5")
    assert ours.returncode == 0, ours.stderr
    (project.parent / "installed" / "launch_testing.py").write_text("")
    real = run_pytest(project, "--launch-args", "rate:=5")
    assert real.returncode == 4
    assert "unrecognized arguments: --launch-args" in real.stderr


def test_a_project_that_imports_nothing_of_it_loads_nothing_of_it(project):
    (project / "test_node.py").write_text(
        "import sys\n\n\n"
        "def test_it():\n"
        "    heavy = {'launch', 'teleopctl.node', 'teleopctl.wire', 'zenoh'}\n"
        "    heavy |= {'teleopctl.interfaces'}\n"
        "    assert not heavy & set(sys.modules)\n"
    )
    done = run_pytest(project)
    assert done.returncode == 0, done.stdout
