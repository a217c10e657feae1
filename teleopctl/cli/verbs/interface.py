"""``teleopctl interface``: message, service and action types."""

import sys

from teleopctl.base.typed import Annotated, Iterable, Iterator
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, OptionSet, Verb, VerbGroup
from teleopctl.errors import NotFoundError, UnsupportedError, UsageError, did_you_mean
from teleopctl.interfaces import known_types, list_types, normalize

GROUP = VerbGroup(
    "Use definitions of messages, services and actions.",
    {
        "list": Verb(f"{__name__}:list_interfaces", "List the types."),
        "package": Verb(f"{__name__}:package_interfaces", "List the types of a package."),
        "packages": Verb(f"{__name__}:interface_packages", "List packages with types."),
        "show": Verb(
            f"{__name__}:show",
            "Print the definition of a type.",
            examples=(
                "teleopctl interface show sensor_msgs/msg/JointState",
                "teleopctl topic type /joint_states | teleopctl interface show -",
            ),
        ),
        "proto": Verb(f"{__name__}:proto", "Print the values of a type, to be filled in."),
        "stubs": Verb(
            f"{__name__}:stubs",
            "Write type stubs of your own message packages, for editors and type checkers.",
            examples=("teleopctl interface stubs typings",),
        ),
    },
    leaves_nothing=True,
)


_TITLES = {"msg": "Messages", "srv": "Services", "action": "Actions"}


class KindOptions(OptionSet):
    """Kinds of types to list: messages, services or actions; all without an option."""

    only_messages: Annotated[bool, Option("-m", "--only-msgs", help="Only messages.")] = False
    only_services: Annotated[bool, Option("-s", "--only-srvs", help="Only services.")] = False
    only_actions: Annotated[bool, Option("-a", "--only-actions", help="Only actions.")] = False

    def selected(self) -> list[str]:
        """Return the selected kinds: ``msg``, ``srv`` and ``action``."""
        options = (self.only_messages, self.only_services, self.only_actions)
        return [
            kind for kind, only in zip(_TITLES, options, strict=True) if only or not any(options)
        ]


def list_interfaces(
    *,
    kinds: KindOptions,
    as_json: AsJson = False,
) -> None:
    """List the types of messages, services and actions."""
    found = {kind: list_types(kind) for kind in kinds.selected()}
    if as_json:
        console.out_json({_TITLES[kind].lower(): names for kind, names in found.items()})
    else:
        console.out_lines(_under_titles(found))


def _under_titles(found: dict[str, list[str]]) -> Iterator[str]:
    for kind, names in found.items():
        yield f"{_TITLES[kind]}:"
        yield from (f"    {name}" for name in names)


def package_interfaces(
    package: Annotated[
        str,
        Argument(metavar="PACKAGE", help="Name of the package.", complete="interface_packages"),
    ],
    *,
    kinds: KindOptions,
    as_json: AsJson = False,
) -> None:
    """List the types of one package."""
    types = known_types()
    found = [name for kind in kinds.selected() for name in types.package_names(package, kind)]
    if not found and not types.package_names(package):
        raise NotFoundError(
            f"Unknown package '{package}'", hint=did_you_mean(package, _packages(_TITLES))
        )
    if as_json:
        console.out_json(found)
    else:
        console.out_lines(found)


def interface_packages(
    *,
    kinds: KindOptions,
    as_json: AsJson = False,
) -> None:
    """List the packages that define messages, services or actions."""
    found = _packages(kinds.selected())
    if as_json:
        console.out_json(found)
    else:
        console.out_lines(found)


def _packages(kinds: Iterable[str]) -> list[str]:
    return sorted({name.split("/", 1)[0] for kind in kinds for name in list_types(kind)})


_Type = Annotated[
    str,
    Argument(
        metavar="TYPE",
        help="Full name, such as std_msgs/msg/String; - reads it from a pipe.",
        complete="interface_types",
    ),
]


def show(
    type_name: _Type,
    all_comments: Annotated[
        bool, Option("--all-comments", help="Include the comments of nested messages.")
    ] = False,
    no_comments: Annotated[
        bool, Option("--no-comments", help="Without comments and empty lines.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the definition of a type, with those of the messages that it holds.

    The definitions of teleopctl's own packages have no comments; those of your packages keep
    theirs.
    """
    if all_comments and no_comments:
        raise UsageError("--all-comments and --no-comments contradict each other")
    name = _known(type_name)
    lines = []
    for line in _shown(name, not no_comments, nested_comments=all_comments):
        lines.append(line)
        # Checked for long definitions only, so that a short command imports few modules.
        if len(lines) % 1000:
            continue
        from teleopctl.base.budget import MOST_ELEMENTS

        if len(lines) > MOST_ELEMENTS:
            raise UnsupportedError(f"{name} has more than {MOST_ELEMENTS:,} lines")
    if as_json:
        console.out_json({"type": name, "definition": "".join(f"{line}\n" for line in lines)})
    else:
        console.out_lines(lines)


def _shown(name: str, comments: bool, *, nested_comments: bool, depth: int = 0) -> Iterator[str]:
    from teleopctl.interfaces import definition_lines

    for line in definition_lines(name):
        text = line.text if comments else line.code
        if text or comments:
            yield "\t" * depth * bool(text) + text
        if line.message is not None:
            yield from _shown(
                line.message, nested_comments, nested_comments=nested_comments, depth=depth + 1
            )


def proto(
    type_name: _Type,
    no_quotes: Annotated[
        bool, Option("--no-quotes", help="Without the quotes around the text.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the default values of a message, request or goal as YAML."""
    from teleopctl.interfaces import get_class, message_to_dict, message_to_yaml

    made = get_class(_known(type_name))
    made = getattr(made, "Goal", None) or getattr(made, "Request", None) or made
    if as_json:
        console.out_json(message_to_dict(made()))
        return
    # The text ends with a line feed, as in ROS 2.
    text = message_to_yaml(made())
    console.out_text(text if no_quotes else f'"{text}"')


def _known(written: str) -> str:
    """Return the full name of an existing type; ``-`` reads the name from stdin.

    Raises:
        NotFoundError: The type is unknown.
        UsageError: The name is to be read from stdin, which is a terminal or empty.
    """
    if written == "-":
        if sys.stdin.isatty():
            raise UsageError("expected stdin pipe")
        written = sys.stdin.readline().strip()
    if not written:
        raise UsageError("the passed value is empty")
    if written.count("/") != 2:
        raise NotFoundError(f"Invalid name '{written}'. Expected three parts separated by '/'")
    types = known_types()
    package = written.split("/", 1)[0]
    if types.find(name := normalize(written)) is not None:
        return name
    if not types.package_names(package):
        raise NotFoundError(f"Unknown package '{package}'")
    raise NotFoundError(f"Could not find the interface '{written}'")


_CONFIGURATION = """\
For type checkers to find them, in the pyproject.toml of your program:

[tool.mypy]
mypy_path = {folder}

[tool.pyright]
stubPath = {folder}
reportMissingModuleSource = false"""


def stubs(
    folder: Annotated[str, Argument(help="Output folder; created if missing.", metavar="DIR")],
    every: Annotated[
        bool,
        Option("--all", help="Those of all packages, for a ROS_DISTRO that is not the default."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write type stubs of your own message packages, for editors and type checkers.

    The stubs of teleopctl's own packages are installed with it. Run this again after a definition
    has changed.
    """
    from pathlib import Path

    from teleopctl.interfaces import write_stubs
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


def complete_types(incomplete: str) -> list[str]:
    """Return completion candidates: the full names of messages, services and actions."""
    from teleopctl.interfaces import list_types

    return [name for name in list_types() if name.startswith(incomplete)]


def complete_packages(incomplete: str) -> list[str]:
    """Return completion candidates: the packages with interfaces."""
    return sorted({name.split("/", 1)[0] for name in complete_types(incomplete)})
