"""``teleopctl interface stubs``: what type checkers read of message packages."""

from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError
from teleopctl.interfaces import known_types, write_stubs

_CONFIGURATION = """\
For type checkers to find them, in the pyproject.toml of your program:

[tool.mypy]
mypy_path = {folder}

[tool.pyright]
stubPath = {folder}
reportMissingModuleSource = false"""


def stubs(
    folder: Annotated[str, Argument(help="Where to; made if needed.", metavar="DIR")],
    every: Annotated[
        bool,
        Option("--all", help="Those of all packages, for a ROS_DISTRO that is not the default."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write what editors and type checkers read of your own message packages.

    Those of the packages that come with teleopctl are installed with it. Run it again when a
    definition has changed.
    """
    from teleopctl.packages import faults_of_search

    for fault in faults_of_search():
        console.warn(fault)
    known = known_types()
    names = known.names() if every else known.user_names()
    if not names:
        raise NotFoundError(
            "No package of your own defines messages, services or actions",
            hint="A package is a folder with a package.xml, below the current folder or on "
            "TELEOPCTL_PACKAGE_PATH, that has msg/, srv/ or action/.",
        )
    packages = write_stubs(Path(folder), names, known.find)
    said = f"Wrote {', '.join(packages)} to {folder}"
    console.out_done(said, as_json=as_json, folder=folder, packages=list(packages))
    import json

    console.note("\n" + _CONFIGURATION.format(folder=json.dumps(Path(folder).as_posix())))
