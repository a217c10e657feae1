"""``teleopctl pkg``: which packages there are, and where."""

from typing import Annotated

from teleopctl import packages
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Group, Verb

GROUP = Group(
    "Find packages.",
    {
        "list": Verb(f"{__name__}:list_packages", "List the packages."),
        "prefix": Verb(f"{__name__}:prefix", "Print the folder of a package's files."),
    },
)


def list_packages(as_json: AsJson = False) -> None:
    """List the packages."""
    listed = packages.list_packages()
    if as_json:
        console.out_json([{"name": one.name, "folder": str(one.folder)} for one in listed])
    else:
        console.out_lines(one.name for one in listed)


def prefix(
    name: Annotated[
        str, Argument(metavar="PACKAGE", help="Name of the package.", complete="packages")
    ],
) -> None:
    """Print the folder of a package's files.

    Where several packages have that name, those that it hides are named on stderr.
    """
    console.out(str(packages.package_share(name)))
    console.flush()
    for hidden in packages.package_layers(name)[1:]:
        programs = ", ".join(sorted(hidden.executables)) or "none"
        console.note(f"It hides {hidden.folder} (programs: {programs})")
