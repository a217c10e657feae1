"""Launch tests: Python files with ``generate_test_description()`` and classes of tests."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path

from teleopctl.compat.launch_file import prefer_own_packages


def run_launch_test(
    file: Path,
    arguments: Iterable[str],
    *,
    package_name: str | None = None,
    verbose: bool = False,
    show_args: bool = False,
    xml_path: str | None = None,
) -> int:
    """Run the launch tests of a file; return 0 if all passed, else 1.

    Args:
        file: Path of the launch test.
        arguments: Launch arguments, ``name:=value``.
        package_name: Package of the test in the report; by default the file's name.
        verbose: Whether to show debug output.
        show_args: Whether to only list the launch arguments, and run no tests.
        xml_path: File to write an xUnit report to, or None.

    Raises:
        TeleopctlError: The file cannot be read, or its launch fails; the message has file and line.
    """
    prefer_own_packages()
    from launch._places import blamed
    from launch_testing.launch_test import run_file

    try:
        return run_file(
            file,
            arguments,
            package_name=package_name,
            verbose=verbose,
            show_args=show_args,
            xml_path=xml_path,
        )
    except Exception as error:
        raise blamed(error, str(file)) from error


def free_domain() -> AbstractContextManager[int]:
    """Return a context manager with a ROS domain id that no other launch test here uses.

    Raises:
        SystemFailureError: All domains are in use.
    """
    prefer_own_packages()
    from domain_coordinator import domain_id

    return domain_id()
