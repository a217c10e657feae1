"""rclpy's own tests, as ROS 2 publishes them; see docs/rclpy_tests.md.

``TELEOPCTL_RCLPY_TESTS`` names their folder, and ``TELEOPCTL_PACKAGE_PATH`` one with ``test_msgs``.
They take five minutes.
"""

import os
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

FOLDER = os.environ.get("TELEOPCTL_RCLPY_TESTS")
PACKAGES = os.environ.get("TELEOPCTL_PACKAGE_PATH", "")
PAGE = Path(__file__).parents[2] / "docs" / "rclpy_tests.md"


def listed() -> set[str]:
    """Return those that do not pass, as ``test_node.py::TestNode::test_take``."""
    names: set[str] = set()
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if row := re.match(r"\| `(test_\w+\.py)` \|([^|]*)\|", line):
            names.update(f"{row[1]}::{name}" for name in re.findall(r"`([\w:]+)`", row[2]))
    return names


def failed(report: Path) -> set[str]:
    names: set[str] = set()
    for case in ET.parse(report).iter("testcase"):
        if case.find("failure") is None and case.find("error") is None:
            continue
        module, *classes = case.attrib["classname"].removeprefix("test.").split(".")
        name = re.sub(r"\[.*| \(.*", "", case.attrib["name"])
        if not module:  # a file that cannot be imported stands for itself
            module = name = name.removeprefix("test.")
        names.add("::".join([f"{module}.py", *classes, name]))
    return names


def test_the_page_lists_tests_by_file():
    assert "test_executor.py::TestExecutor::test_multi_threaded_executor_num_threads" in listed()


@pytest.mark.timeout(900)
@pytest.mark.skipif(not FOLDER, reason="TELEOPCTL_RCLPY_TESTS names no folder")
def test_all_pass_but_those_that_the_page_lists(ros, tmp_path):
    assert FOLDER
    shutil.copytree(FOLDER, tmp_path / "test")
    # It loads a library in C++, of one of the tests.
    (tmp_path / "test" / "__init__.py").write_text("")
    ros.env["TELEOPCTL_PACKAGE_PATH"] = PACKAGES
    not_listed: dict[str, str] = {}
    for file in sorted((tmp_path / "test").glob("test_*.py")):  # each in a process, as in ROS 2
        report = tmp_path / f"{file.stem}.xml"
        ended = ros.run_module(
            "teleopctl",
            ["python", "-m", "pytest", "-q", "--timeout=60", f"--junit-xml={report}", str(file)],
            timeout=300,
            cwd=tmp_path,
        )
        assert report.exists(), ended.stdout + ended.stderr
        not_listed |= dict.fromkeys(failed(report) - listed(), ended.stdout)
    assert not not_listed, "\n".join([*not_listed, *not_listed.values()])
