"""``teleopctl extensions``, ``extension_points`` and ``plugin list``: plug-ins and their kinds.

The registry is `teleopctl.plugins`: a kind of plug-in is what ros2 calls an extension point.
"""

import sys
from collections.abc import Iterator

from teleopctl import plugins
from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Option, Verb, VerbGroup
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.plugins import Kind, Plugin

EXTENSIONS = Verb(f"{__name__}:list_extensions", "List plug-ins, built-in and installed ones.")
EXTENSION_POINTS = Verb(f"{__name__}:list_extension_points", "List the kinds of plug-ins.")
PLUGIN = VerbGroup(
    "List plug-ins by their packages.",
    {"list": Verb(f"{__name__}:list_plugins", "List plug-ins by their packages.")},
)

_OURS = "teleopctl"

ShowAll = Annotated[
    bool, Option("-a", "--all", help="Include plug-ins that cannot be loaded, marked with -.")
]
Verbose = Annotated[bool, Option("-v", "--verbose", help="Show where each one is defined.")]


def list_extensions(
    show_all: ShowAll = False, verbose: Verbose = False, as_json: AsJson = False
) -> None:
    """List plug-ins, built-in and installed ones.

    Imports each plug-in except programs, to find those that cannot be loaded; this takes a while.
    """
    from contextlib import redirect_stdout

    from teleopctl.compat import activation

    activation.activate()  # plug-ins may import rclpy, and so do teleopctl's own
    with redirect_stdout(sys.stderr):
        found = {
            kind: [(plugin, *_loaded(kind, plugin)) for plugin in plugins.available(kind).values()]
            for kind in plugins.kinds()
        }
    if as_json:
        console.out_json(
            [
                {
                    "group": kind.group,
                    "name": plugin.name,
                    "target": plugin.target,
                    "distribution": plugin.distribution or _OURS,
                    "summary": summary,
                    "reason": reason,
                }
                for kind, entries in found.items()
                for plugin, summary, reason in entries
            ]
        )
        return
    for kind, entries in found.items():
        console.out(kind.group)
        for plugin, summary, reason in sorted(entries, key=lambda entry: entry[0].name):
            if reason is None or show_all:
                prefix = " " if reason is None else "-"
                console.out_lines(_described(prefix, plugin, summary, reason, verbose=verbose))


def _described(
    prefix: str, plugin: Plugin, summary: str, reason: str | None, *, verbose: bool
) -> Iterator[str]:
    yield f"{prefix} {plugin.name}: {summary}"
    if verbose:
        module, _, attributes = plugin.target.partition(":")
        yield f"{prefix}   module_name: {module}"
        if attributes:
            yield f"{prefix}   attributes: {attributes}"
        distribution = plugin.distribution or _OURS
        yield f"{prefix}   distribution: {distribution} {_version(distribution)}"
    if reason is not None:
        yield f"{prefix}   reason: {reason}"


def _loaded(kind: Kind, plugin: Plugin) -> tuple[str, str | None]:
    """Return the summary of a plug-in, and the reason why it cannot be loaded, or None."""
    if kind is plugins.PACKAGES:
        return "", None  # modules of packages with data files, which are not imported
    if kind is plugins.NODES:
        return _program(plugin.target)
    try:
        found = plugins.load(kind, plugin.name)
    except (Exception, SystemExit) as error:  # noqa: BLE001 -- any exception is a reason
        return "", " ".join(str(error).split()) or type(error).__name__
    if isinstance(found, Verb | VerbGroup):
        return found.help, None
    # A program's function is called main, and its module's docstring describes the program.
    described = found
    if getattr(found, "__name__", "") == "main":
        described = sys.modules[found.__module__]
    first, _, _ = (getattr(described, "__doc__", "") or "").partition("\n")
    return first.replace("``", ""), None


def _program(target: str) -> tuple[str, str | None]:
    """Return summary and reason for a program from its source, since importing may run it."""
    import ast
    from importlib.util import find_spec
    from pathlib import Path

    module, _, function = target.partition(":")
    try:
        spec = find_spec(module)
        if spec is None or spec.origin is None:
            return "", f"No module named '{module}'"
        if not spec.origin.endswith(".py"):
            return "", None
        tree = ast.parse(Path(spec.origin).read_bytes())
    except Exception as error:  # noqa: BLE001 -- find_spec imports the parent package
        return "", " ".join(str(error).split()) or type(error).__name__
    described: ast.Module | ast.FunctionDef = tree
    for statement in tree.body if function != "main" else ():
        if isinstance(statement, ast.FunctionDef) and statement.name == function:
            described = statement
    first, _, _ = (ast.get_docstring(described) or "").partition("\n")
    return first.replace("``", ""), None


def _version(distribution: str) -> str:
    from importlib.metadata import version

    return version(distribution)


def list_extension_points(
    show_all: ShowAll = False, verbose: Verbose = False, as_json: AsJson = False
) -> None:
    """List the kinds of plug-ins, which are entry-point groups."""
    del show_all  # the kinds of teleopctl can always be imported
    kinds = plugins.kinds()
    if as_json:
        console.out_json(
            [{"group": kind.group, "noun": kind.noun, "bases": list(kind.bases)} for kind in kinds]
        )
        return
    for kind in kinds:
        console.out(f"{kind.group}: {kind.noun}")
        if verbose:
            for base in kind.bases:
                module, _, attributes = base.partition(":")
                console.out(f"    module_name: {module}")
                console.out(f"    attributes: {attributes}")
            console.out(f"    version: {_version(_OURS)}")


def list_plugins(
    packages_only: Annotated[
        bool, Option("--packages", help="Print only the packages that have plug-ins.")
    ] = False,
    package: Annotated[
        str | None, Option("--package", help="Only the plug-ins of this package.", metavar="NAME")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List plug-ins by their packages, with class and base class.

    Lists plug-ins that have a base class, such as controllers, hardware and sensors, without
    importing them.
    """
    by_package: dict[str, list[tuple[Plugin, str]]] = {}
    for kind in plugins.kinds():
        if kind.bases and kind.classes:
            for plugin in plugins.available(kind).values():
                by_package.setdefault(_package_of(plugin), []).append((plugin, kind.bases[0]))
    if package is not None:
        if package not in by_package:
            raise NotFoundError(
                f"Package '{package}' has no plug-ins", hint=did_you_mean(package, by_package)
            )
        by_package = {package: by_package[package]}
    if as_json:
        console.out_json(
            [
                {"package": owner, "name": plugin.name, "type": plugin.target, "base": base}
                for owner, members in sorted(by_package.items())
                for plugin, base in members
            ]
        )
        return
    for owner, members in sorted(by_package.items()):
        console.out(owner if packages_only else f"{owner}:")
        if not packages_only:
            console.out_lines(
                f"\t{plugin.name} [{_dotted(plugin.target)}] (base: {_dotted(base)})"
                for plugin, base in members
            )


def _package_of(plugin: Plugin) -> str:
    """Return the package in a plug-in's name, as in ``pkg/Class``, else its distribution."""
    package, slash, _ = plugin.name.partition("/")
    return package if slash else plugin.distribution or _OURS


def _dotted(target: str) -> str:
    return target.replace(":", ".")
