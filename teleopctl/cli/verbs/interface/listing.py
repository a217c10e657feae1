"""``teleopctl interface list|package|packages``: which types there are."""

from collections.abc import Iterator

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.interfaces import known_types, list_types

_TITLES = {"msg": "Messages", "srv": "Services", "action": "Actions"}

_OnlyMessages = Annotated[bool, Option("-m", "--only-msgs", help="Only messages.")]
_OnlyServices = Annotated[bool, Option("-s", "--only-srvs", help="Only services.")]
_OnlyActions = Annotated[bool, Option("-a", "--only-actions", help="Only actions.")]


def list_interfaces(
    only_messages: _OnlyMessages = False,
    only_services: _OnlyServices = False,
    only_actions: _OnlyActions = False,
    as_json: AsJson = False,
) -> None:
    """List the types of messages, services and actions."""
    kinds = _kinds(only_messages, only_services, only_actions)
    found = {kind: list_types(kind) for kind in kinds}
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
    only_messages: _OnlyMessages = False,
    only_services: _OnlyServices = False,
    only_actions: _OnlyActions = False,
    as_json: AsJson = False,
) -> None:
    """List the types of one package."""
    types = known_types()
    kinds = _kinds(only_messages, only_services, only_actions)
    found = [name for kind in kinds for name in types.package_names(package, kind)]
    if not found and not types.package_names(package):
        raise NotFoundError(
            f"Unknown package '{package}'", hint=did_you_mean(package, _packages(_TITLES))
        )
    if as_json:
        console.out_json(found)
    else:
        console.out_lines(found)


def interface_packages(
    only_messages: _OnlyMessages = False,
    only_services: _OnlyServices = False,
    only_actions: _OnlyActions = False,
    as_json: AsJson = False,
) -> None:
    """List the packages that define messages, services or actions."""
    found = _packages(_kinds(only_messages, only_services, only_actions))
    if as_json:
        console.out_json(found)
    else:
        console.out_lines(found)


# dict: of its keys, the kinds, only the order counts.
def _packages(kinds: dict[str, str]) -> list[str]:
    return sorted({name.split("/", 1)[0] for kind in kinds for name in list_types(kind)})


def _kinds(only_messages: bool, only_services: bool, only_actions: bool) -> dict[str, str]:
    """Return the kinds that are asked for with their titles: all where none is."""
    asked = {"msg": only_messages, "srv": only_services, "action": only_actions}
    every = not any(asked.values())
    return {kind: title for kind, title in _TITLES.items() if every or asked[kind]}
