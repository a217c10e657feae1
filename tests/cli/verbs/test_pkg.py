"""``teleopctl pkg``: the packages that there are, and what hides what."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.packages.prefix import INDEX, install, write

SETUP_PY = """
from setuptools import setup

setup(
    name="arm",
    data_files=[("share/arm/launch", ["up.launch.yaml"]), ("share/arm", ["package.xml"])],
    entry_points={"console_scripts": ["talk = arm.talk:main"]},
)
"""


posix = pytest.mark.skipif(sys.platform == "win32", reason="paths and scripts of POSIX")


@pytest.fixture
def ros(ros_without_router):
    """With a source package ``arm`` below the current folder, which hides an installed one."""
    ros = ros_without_router
    folder = ros.folder / "src/arm"
    write(
        folder / "package.xml",
        """\
        <?xml version="1.0"?>
        <!-- an arm -->
        <package format="3">
          <name>arm</name>
          <version>0.1.0</version>
          <depend>rclpy</depend>
          <depend>std_msgs</depend>
          <url/>
        </package>
        """,
    )
    write(folder / "setup.py", SETUP_PY)
    write(folder / "up.launch.yaml", "launch: []\n")
    write(folder / "arm/talk.py", "def main():\n    print('talking')\n")
    ros.env["AMENT_PREFIX_PATH"] = str(install(ros.folder / "install", "arm"))
    return ros


def elsewhere(ros) -> Path:
    folder: Path = ros.folder / "elsewhere"
    folder.mkdir()
    return folder


def test_every_package_is_listed_by_its_name(ros):
    listed = ros.run("pkg list").stdout.split()
    assert listed == sorted(listed)
    assert {"arm", "controller_manager", "teleop_description", "teleopctl"} <= set(listed)


@posix
def test_where_each_package_was_found_and_what_it_hides_is_told(ros):
    write(ros.folder / "src/second_arm/package.xml", "<package><name>arm</name></package>")
    write(ros.folder / "src/nameless/package.xml", "<package/>")
    told = ros.run("pkg list --verbose")
    around = [line for line in told.stdout.splitlines() if f"{ros.folder}" in line]
    assert around == [
        f"arm  {ros.folder}/src/arm  [below the current folder]",
        f"  hides  {ros.folder}/src/second_arm  [below the current folder]",
        f"  hides  {ros.folder}/install/share/arm  [AMENT_PREFIX_PATH]",
    ]
    assert "nameless/package.xml has no readable <name>" in told.stderr
    entries = {entry["name"]: entry for entry in json.loads(ros.run("pkg list --json").stdout)}
    assert [hidden["folder"] for hidden in entries["arm"]["hides"]] == [
        f"{ros.folder}/src/second_arm",
        f"{ros.folder}/install/share/arm",
    ]
    assert entries["teleop_description"]["source"] == "teleopctl"


@posix
def test_the_prefix_of_a_source_package_is_laid_out_as_an_installed_one(ros):
    told = ros.run("pkg prefix arm")
    prefix = Path(told.stdout.removesuffix("\n"))
    assert told.stderr == f"It hides {ros.folder}/install/share/arm (programs: none)\n"
    assert (prefix / "share/ament_index/resource_index/packages/arm").is_file()
    assert (prefix / "share/arm/launch/up.launch.yaml").read_text() == "launch: []\n"
    share = ros.run("pkg prefix --share arm").stdout.removesuffix("\n")
    assert Path(share).resolve() == (prefix / "share/arm").resolve()
    ros.env["AMENT_PREFIX_PATH"] = str(prefix)
    assert ros.run("pkg prefix arm", cwd=elsewhere(ros)).stdout == told.stdout


@posix
def test_a_program_is_listed_and_run_by_its_path_from_anywhere(ros):
    assert ros.run("pkg executables arm").stdout == "arm talk\n"
    every = ros.run("pkg executables").stdout.splitlines()
    assert {"arm talk", "controller_manager spawner", "tf2_ros tf2_echo"} <= set(every)
    path = ros.run("pkg executables --full-path arm").stdout.removesuffix("\n")
    assert path == ros.run("pkg prefix arm").stdout.removesuffix("\n") + "/lib/arm/talk"
    done = subprocess.run(
        [path],
        cwd=elsewhere(ros),
        env={**os.environ, **ros.env},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "talking\n"


def test_the_manifest_is_printed_without_its_comments_or_by_tag(ros):
    assert ros.run("pkg xml arm").stdout == (
        '<package format="3">\n  <name>arm</name>\n  <version>0.1.0</version>\n'
        "  <depend>rclpy</depend>\n  <depend>std_msgs</depend>\n  <url/>\n</package>\n"
    )
    assert ros.run("pkg xml arm -t depend").stdout == "rclpy\nstd_msgs\n"


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("prefix armm", "Package not found: 'armm'"),
        ("xml armm", "Package not found: 'armm'"),
        ("executables armm", "Package 'armm' not found"),
        ("xml arm -t depends", "XML tag not found: "),
        ("xml bare", "Package XML manifest not found"),
    ],
)
def test_what_is_not_there_is_an_error_that_says_so(ros, line, told):
    write(ros.folder / "install" / INDEX / "packages/bare", "")
    failed = ros.run(f"pkg {line}")
    assert (failed.stdout, failed.returncode) == ("", 1)
    assert told in failed.stderr
    if "arm" in line:
        assert "arm" in failed.stderr.splitlines()[-1] or "depend" in failed.stderr
