"""``launch_testing.launch_test``: the ``launch_test`` command."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from .junitxml import unittestResultsToXml
from .loader import LoadTestsFromPythonModule
from .print_arguments import print_arguments_of_launch_description
from .test_runner import LaunchTestRunner


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments to a parser."""
    parser.add_argument("launch_test_file", help="The file with generate_test_description().")
    parser.add_argument("--package-name", help="Package of the test, in the xUnit report.")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="Show lines for finding mistakes."
    )
    parser.add_argument(
        *("-s", "--show-args", "--show-arguments"),
        action="store_true",
        help="List the arguments that the test takes, and run nothing.",
    )
    parser.add_argument("launch_arguments", nargs="*", help="Arguments: name:=value.")
    parser.add_argument("--junit-xml", dest="xmlpath", help="Write an xUnit report to this file.")


def run(
    parser: argparse.ArgumentParser,
    args: argparse.Namespace,
    test_runner_cls: type[LaunchTestRunner] = LaunchTestRunner,
) -> int:
    """Run the tests of a file as `run_file` does; a missing file is a usage error."""
    if not Path(args.launch_test_file).is_file():
        parser.error(f"Test file '{args.launch_test_file}' does not exist")
    return run_file(
        Path(args.launch_test_file),
        args.launch_arguments,
        package_name=args.package_name,
        verbose=args.verbose,
        show_args=args.show_args,
        xml_path=args.xmlpath,
        test_runner_cls=test_runner_cls,
    )


def run_file(
    file: Path,
    arguments: Iterable[str] = (),
    *,
    package_name: str | None = None,
    verbose: bool = False,
    show_args: bool = False,
    xml_path: str | None = None,
    test_runner_cls: type[LaunchTestRunner] = LaunchTestRunner,
) -> int:
    """Run the tests of a file; return 0 if all have passed, else 1.

    Args:
        file: Has ``generate_test_description`` and classes of tests.
        arguments: Arguments of the launch: ``name:=value``.
        package_name: Package of the test, in the report; by default the file's name.
        verbose: Whether lines for finding mistakes are shown.
        show_args: Whether to list which arguments it takes, and to run nothing.
        xml_path: File to write an xUnit report to, or None.
        test_runner_cls: Class that runs the tests.
    """
    package = package_name or file.stem
    module = _module(package, file.absolute())
    runs = LoadTestsFromPythonModule(module, name=f"{package}.{file.stem}.launch_tests")
    runner = test_runner_cls(runs, arguments, verbose)
    runner.validate()
    if show_args:
        print_arguments_of_launch_description(launch_description=runs[0].get_launch_description())
        return 0
    results = runner.run()
    if xml_path is not None:
        report = unittestResultsToXml(test_results=results, name=f"{package}.{file.stem}")
        report.write(xml_path, encoding="utf-8", xml_declaration=True)
    return 0 if all(result.wasSuccessful() for result in results.values()) else 1


def _module(name: str, file: Path) -> ModuleType:
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} is no Python file")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    if not hasattr(module, "generate_test_description"):
        raise AttributeError(f"launch test {file} has no function generate_test_description()")
    return module


def main() -> None:
    """Run the command, and exit: 0, 1 if tests have failed, 2 if they could not be run."""
    parser = argparse.ArgumentParser(prog="launch_test", description="Test a launch description.")
    add_arguments(parser)
    args = parser.parse_args()
    try:
        status = run(parser, args)
    except Exception as error:  # noqa: BLE001 -- reports any error of the user's file
        parser.error(str(error))
    sys.exit(status)


if __name__ == "__main__":
    main()
