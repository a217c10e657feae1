"""``ament_mypy.main``. Checks of types by mypy, where it is installed."""

import importlib.util
import subprocess
import sys
from collections.abc import Sequence

from ament_lint.checking import parser_of, paths_to_exclude, skip

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Check the types of files; return 0 if mypy finds no error.

    Args:
        argv: Command line with files and folders; that of the process if None.

    Raises:
        UnavailableError: mypy is not installed; a running test is skipped.
    """
    parser = parser_of("Check types by mypy.")
    parser.add_argument("--config", metavar="path", dest="config_file", help="mypy's config file.")
    args = parser.parse_args(sys.argv[1:] if argv is None else list(argv))
    if importlib.util.find_spec("mypy") is None:
        skip("this check needs mypy: pip install mypy")
    command = [sys.executable, "-m", "mypy", "--ignore-missing-imports", "--no-incremental"]
    if args.config_file:
        command += ["--config-file", args.config_file]
    for name in paths_to_exclude(args.excludes):
        command += ["--exclude", name]
    return subprocess.run([*command, *args.paths], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
