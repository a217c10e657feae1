"""``ament_pep257.main``. Checks of docstrings by pydocstyle's rules D, done by Ruff."""

import sys
from collections.abc import Sequence

from ament_lint.checking import check_files, parser_of, paths_to_exclude

__all__ = ["main"]

# The rules that ament's convention leaves out.
_IGNORED = (
    *("D100", "D101", "D102", "D103", "D104", "D105", "D106", "D107"),
    *("D203", "D212", "D404"),
)
_CONVENTIONS = ("ament", "google", "numpy", "pep257")


def main(argv: Sequence[str] | None = None) -> int:
    """Check the docstrings of files; return 0 if there is no problem, else 1.

    Args:
        argv: Command line with files and folders; that of the process if None.

    Raises:
        UnavailableError: Ruff is not installed; a running test is skipped.
    """
    parser = parser_of("Check docstrings by PEP 257.")
    rules = parser.add_mutually_exclusive_group()
    rules.add_argument("--ignore", nargs="+", default=[], help="Codes not to check.")
    rules.add_argument("--select", nargs="+", default=[], help="Codes to check.")
    rules.add_argument("--convention", choices=_CONVENTIONS, default="ament")
    parser.add_argument("--add-ignore", nargs="+", default=[], help="Further codes not to check.")
    parser.add_argument("--add-select", nargs="+", default=[], help="Further codes to check.")
    args = parser.parse_args(sys.argv[1:] if argv is None else list(argv))
    is_default = not (args.select or args.ignore)
    options = []
    if is_default and args.convention != "ament":
        options = ["--config", f"lint.pydocstyle.convention = '{args.convention}'"]
    ignored = args.ignore or (_IGNORED if is_default and not options else ())
    problems = check_files(
        args.paths,
        select=[*(args.select or ["D"]), *args.add_select],
        ignore=[*ignored, *args.add_ignore],
        excludes=paths_to_exclude(args.excludes),
        options=options,
    )
    for problem in problems:
        print(problem, file=sys.stderr)
    if problems:
        print(f"{len(problems)} errors", file=sys.stderr)
        return 1
    print("No problems found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
