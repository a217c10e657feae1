"""``ament_flake8.main``. Checks of Python code by flake8's rules E, F and W, done by Ruff."""

import collections
import linecache
import re
import sys
from collections.abc import Sequence

from ament_lint.checking import Problem, check_files, parser_of, paths_to_exclude

__all__ = ["main", "main_with_errors"]

# Line length of ament, and the rules that flake8 leaves out by default.
_LINE_LENGTH = 99
_IGNORED = ("E226", "E24")
# Rules that are in Ruff's preview, in which other rules are stricter than flake8's.
_BLANKS = ("E1", "E2", "E3", "W39")

_TEXTS = {
    "E713": r"\bnot\s+[^][(){} ]+\s+in\s",
    "E714": r"\bnot\s+[^][(){} ]+\s+is\s",
    "E731": r"=\s*lambda\b",
}
"""Texts of the problems that flake8 finds: not in parentheses, behind a break, with an index."""


def main(argv: Sequence[str] | None = None) -> int:
    """Check files; return 0 if there is no problem, else 1.

    Args:
        argv: Command line with files and folders; that of the process if None.
    """
    return main_with_errors(argv)[0]


def main_with_errors(argv: Sequence[str] | None = None) -> tuple[int, list[str]]:
    """Check files; return 0 or 1, and the problems, one a line.

    Args:
        argv: Command line with files and folders; that of the process if None.

    Raises:
        UnavailableError: Ruff is not installed; a running test is skipped.
    """
    parser = parser_of("Check Python code by flake8's rules E, F and W.")
    parser.add_argument(
        "--linelength", metavar="N", type=int, default=_LINE_LENGTH, help="Longest line."
    )
    args = parser.parse_args(sys.argv[1:] if argv is None else list(argv))
    excludes = paths_to_exclude(args.excludes)
    length = ("--line-length", str(args.linelength))
    found = check_files(
        args.paths, select=("E", "F", "W"), ignore=_IGNORED, excludes=excludes, options=length
    )
    found += check_files(
        args.paths,
        select=_BLANKS,
        ignore=_IGNORED,
        excludes=excludes,
        options=("--preview", *length),
    )
    problems = sorted({problem for problem in found if not _is_allowed(problem)})
    for problem in problems:
        print(problem)
    counts = collections.Counter(problem.code[0] for problem in problems)
    print(f"\n{len(problems)} errors" if problems else "\nNo problems found")
    for kind, count in sorted(counts.items()):
        print(f"'{kind}'-type errors: {count}")
    return int(bool(problems)), [str(problem) for problem in problems]


def _is_allowed(problem: Problem) -> bool:
    """Return whether flake8, which checks the text, allows what Ruff finds in the syntax tree."""
    pattern = _TEXTS.get(problem.code)
    line = linecache.getline(problem.file, problem.line)
    return pattern is not None and re.search(pattern, line) is None


if __name__ == "__main__":
    sys.exit(main())
