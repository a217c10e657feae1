"""``teleopctl test``: launch tests of ROS 2."""

import contextlib
import os
from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.verb import Argument, Option, Verb
from teleopctl.errors import UsageError

VERB = Verb(
    f"{__name__}:test",
    "Run the launch tests of a Python file.",
    examples=(
        "teleopctl test test/talker_launch_test.py",
        "teleopctl test --junit-xml report.xml --package-name my_pkg test/arm_test.py rate:=50",
    ),
)


def test(
    words: Annotated[
        list[str],
        Argument(
            metavar="FILE [NAME:=VALUE]...",
            help="A file with generate_test_description() and tests; its launch arguments.",
        ),
    ],
    package_name: Annotated[
        str | None,
        Option("--package-name", metavar="NAME", help="Package of the test, in the report."),
    ] = None,
    verbose: Annotated[
        bool, Option("--verbose", "-v", help="Print debug messages of the launch.")
    ] = False,
    show_args: Annotated[
        bool,
        Option("--show-args", "-s", "--show-arguments", help="List the test's launch arguments."),
    ] = False,
    junit_xml: Annotated[
        str | None, Option("--junit-xml", metavar="FILE", help="Write an xUnit report.")
    ] = None,
    disable_isolation: Annotated[
        bool,
        Option(
            "--disable-isolation",
            help="Test in ROS domain 0. Without it, and where ROS_DOMAIN_ID is not set, the test "
            "gets a domain that no other test has.",
        ),
    ] = False,
) -> int:
    """Run the launch tests of a Python file, as ros2 test and launch_test do.

    The exit status is 0 if all tests pass, else 1.
    """
    from teleopctl.compat.activation import activate_children
    from teleopctl.compat.launch_test import free_domain, run_launch_test

    file, *arguments = words
    if not Path(file).is_file():
        hint = None
        if Path(file).is_dir():
            hint = f"For the tests of a package: teleopctl python -m pytest {file}"
        raise UsageError(f"There is no launch test {file}", hint=hint)
    # Commands of the test run with what `launch` gives to its own.
    activate_children()
    with contextlib.ExitStack() as reserved:
        if not show_args and not disable_isolation and "ROS_DOMAIN_ID" not in os.environ:
            domain = reserved.enter_context(free_domain())
            console.out(f"Running with ROS_DOMAIN_ID {domain}")
            os.environ["ROS_DOMAIN_ID"] = str(domain)
        return run_launch_test(
            Path(file),
            arguments,
            package_name=package_name,
            verbose=verbose,
            show_args=show_args,
            xml_path=junit_xml,
        )
