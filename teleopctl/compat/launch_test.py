"""Launch tests: Python files with ``generate_test_description()`` and classes of tests."""

from __future__ import annotations

import random
import socket
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from teleopctl.compat.launch_file import prefer_own_packages
from teleopctl.errors import SystemFailureError

# Same as in ROS 2's domain_coordinator, so that runs of both use different domains.
_DOMAINS = range(1, 101)
_FIRST_PORT = 22119


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


@contextmanager
def free_domain() -> Iterator[int]:
    """Yield a ROS domain id that no other launch test here uses during the ``with`` block.

    Raises:
        SystemFailureError: All domains are in use.
    """
    for domain in random.sample(_DOMAINS, len(_DOMAINS)):
        with socket.socket() as taken:
            try:
                taken.bind(("127.0.0.1", _FIRST_PORT + domain))
            except OSError:
                continue
            yield domain
            return
    raise SystemFailureError(
        f"Launch tests run in all {len(_DOMAINS)} ROS domains",
        hint="Wait for one of them to end, or set ROS_DOMAIN_ID.",
    )
