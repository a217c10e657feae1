"""``teleopctl help`` and ``teleopctl version``."""

from teleopctl.base import __version__
from teleopctl.base.typed import Annotated
from teleopctl.cli import console, declared, help_page, main
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Verb, VerbGroup

HELP = Verb(
    f"{__name__}:show_help",
    "Explain a verb, as --help does behind it.",
    examples=("teleopctl help topic echo",),
)
VERSION = Verb(f"{__name__}:show_version", "Print the version, as --version does.")


def show_help(
    words: Annotated[
        list[str] | None, Argument(metavar="VERB", help="The verb; by default the program.")
    ] = None,
) -> None:
    """Print the help page of the program, of a noun or of a verb."""
    path = list(words or ())
    found = declared.find_declaration(path[:1]) if path else None
    if path:
        main.refuse_unknown_verb(path)
    # A single verb takes no further words, and a noun one.
    length = 2 if isinstance(found, VerbGroup) else 1
    help_page.print_requested_page([*path[:length], "--help"])


def show_version(as_json: AsJson = False) -> None:
    """Print the version of teleopctl."""
    console.out_done(f"teleopctl {__version__}", as_json=as_json, version=__version__)
