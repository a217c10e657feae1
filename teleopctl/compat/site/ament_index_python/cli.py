"""``ament_index_python.cli``: the resources of the ament index, for a terminal."""

import argparse
import sys
from collections.abc import Sequence

from ament_index_python.resources import get_resource, get_resource_types, get_resources

__all__ = ["main", "resource_name_completer", "resource_type_completer"]


def main(argv: Sequence[str] | None = None) -> str | None:
    """Print the types, the resources of a type, or one resource; return an error's text."""
    parser = argparse.ArgumentParser(description="Query the ament resource index.")
    parser.add_argument("resource_type", nargs="?", metavar="TYPE", help="The type.")
    parser.add_argument("resource_name", nargs="?", metavar="NAME", help="The resource's name.")
    given = parser.parse_args(sys.argv[1:] if argv is None else argv)
    if given.resource_type is None:
        for name in sorted(get_resource_types()):
            print(name)  # noqa: T201
        return None
    if given.resource_name is None:
        for name, prefix in sorted(get_resources(given.resource_type).items()):
            print(f"{name}\t{prefix}")  # noqa: T201
        return None
    try:
        content, prefix = get_resource(given.resource_type, given.resource_name)
    except (LookupError, OSError) as error:
        return str(error)
    print(prefix)  # noqa: T201
    if content:
        print(f"<<<\n{content}\n>>>")  # noqa: T201
    return None


def resource_type_completer(prefix: str | tuple[str, ...], **_: object) -> list[str]:
    """Return the types that begin so, for argcomplete."""
    return [name for name in get_resource_types() if name.startswith(prefix)]


def resource_name_completer(
    prefix: str | tuple[str, ...], parsed_args: argparse.Namespace, **_: object
) -> list[str]:
    """Return the resources of the type on the line that begin so, for argcomplete."""
    resource_type = getattr(parsed_args, "resource_type", None)
    names = get_resources(resource_type) if resource_type else ()
    return [name for name in names if name.startswith(prefix)]
