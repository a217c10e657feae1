"""Problems that Ruff finds in Python files, and the skip of a check that is not possible."""

import argparse
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from teleopctl.errors import UnavailableError

__all__ = ["Problem", "check_files", "parser_of", "paths_to_exclude", "skip"]


class Problem(NamedTuple):
    """Problem in a file; line and column count from 1."""

    file: str
    line: int
    column: int
    code: str
    message: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.code} {self.message}"


def skip(reason: str) -> NoReturn:
    """Skip the running test with a reason.

    Raises:
        UnavailableError: No test runs.
    """
    if "pytest" in sys.modules and "PYTEST_CURRENT_TEST" in os.environ:
        import pytest

        pytest.skip(reason)
    raise UnavailableError(reason)


def parser_of(description: str) -> argparse.ArgumentParser:
    """Return a parser of the arguments that all linters have."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("paths", nargs="*", default=[os.curdir], help="Files or folders to check.")
    parser.add_argument(
        "--exclude",
        nargs="*",
        default=[],
        dest="excludes",
        metavar="filename",
        help="Files and folders to leave out.",
    )
    return parser


def paths_to_exclude(excludes: Iterable[str]) -> list[str]:
    """Return the given names and the folders that linters leave out: with AMENT_IGNORE, ., _."""
    found = list(excludes)
    for folder, names, files in os.walk("."):
        if "AMENT_IGNORE" in names or "AMENT_IGNORE" in files:
            found.append(str(Path(folder).resolve()))
            names.clear()
            continue
        hidden = [name for name in names if name.startswith((".", "_"))]
        found += hidden
        names[:] = [name for name in names if name not in hidden]
    return found


def check_files(
    paths: Sequence[str],
    *,
    select: Sequence[str],
    ignore: Sequence[str],
    excludes: Sequence[str] = (),
    options: Sequence[str] = (),
) -> list[Problem]:
    """Return the problems that Ruff finds in Python files.

    Args:
        paths: Files and folders.
        select: Codes, or beginnings of codes, of the rules to check.
        ignore: Codes of rules among these that are not checked.
        excludes: Files and folders to leave out.
        options: Further options of ``ruff check``.

    Raises:
        UnavailableError: Ruff is not installed, or cannot check; a running test is skipped where it
            is not installed.
    """
    paths = [path for path in paths if str(Path(path).resolve()) not in excludes]
    if not paths:
        return []
    command = [
        *(*_ruff(), "check", "--isolated", "--no-cache", "--exit-zero", "--quiet"),
        *("--no-respect-gitignore", "--output-format", "json"),
        *("--select", ",".join(select), "--ignore", ",".join(ignore), *options),
        *(word for name in excludes for word in ("--exclude", name)),
        *("--", *paths),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise UnavailableError(f"ruff check failed: {done.stderr.strip()}")
    here = Path.cwd()
    problems = []
    found: list[dict[str, Any]] = json.loads(done.stdout)  # Any: JSON
    for entry in found:
        file = Path(entry["filename"])
        shown = file.relative_to(here) if file.is_relative_to(here) else file
        place = entry["location"]
        code = entry["code"] or "E999"  # a syntax error, as flake8 numbers it
        problems.append(Problem(str(shown), place["row"], place["column"], code, entry["message"]))
    return problems


def _ruff() -> list[str]:
    if importlib.util.find_spec("ruff") is not None:
        return [sys.executable, "-m", "ruff"]
    if (program := shutil.which("ruff")) is not None:
        return [program]
    skip("this check needs Ruff: pip install 'teleopctl[lint]'")
