"""``ament_xmllint.main``. Checks that XML files are well-formed.

Schemas are not used: those of ROS packages are on the network.
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from ament_lint.checking import parser_of, paths_to_exclude
from lxml import etree

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Check that XML files are well-formed; return 0 if all are, else 1.

    Args:
        argv: Command line with files and folders; that of the process if None.
    """
    parser = parser_of("Check that XML files are well-formed.")
    parser.add_argument("--extensions", nargs="*", default=["xml"], help="Extensions of the files.")
    args = parser.parse_args(sys.argv[1:] if argv is None else list(argv))
    excludes = paths_to_exclude(args.excludes)
    files = [file for path in args.paths for file in _files(Path(path), args.extensions, excludes)]
    if not files:
        print("No files found", file=sys.stderr)
        return 1
    invalid = 0
    for file in files:
        try:
            etree.parse(file)
        except etree.XMLSyntaxError as error:
            invalid += 1
            print(f"File '{file}' is invalid:\n{error}\n", file=sys.stderr)
        else:
            print(f"File '{file}' is valid\n")
    if invalid:
        print(f"{invalid} files are invalid", file=sys.stderr)
        return 1
    print("No problems found")
    return 0


def _files(path: Path, extensions: Sequence[str], excludes: Sequence[str]) -> Iterator[Path]:
    if path.is_file():
        yield path
        return
    for file in sorted(path.rglob("*")):
        parts = {*file.relative_to(path).parts, *map(str, file.resolve().parents)}
        if file.suffix[1:] in extensions and file.is_file() and parts.isdisjoint(excludes):
            yield file


if __name__ == "__main__":
    sys.exit(main())
