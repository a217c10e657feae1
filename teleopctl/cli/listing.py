"""Output and lookup of names with types, shared by the verbs of topics, services and actions."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli import console
from teleopctl.errors import InvalidTypeNameError, NotFoundError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    NamesAndTypes = Sequence[tuple[str, Sequence[str]]]


def out_names(
    entries: NamesAndTypes,
    *,
    only_count: bool,
    show_types: bool = False,
    as_json: bool = False,
) -> None:
    """Print the given names, one per line, optionally with types, or their number, or JSON.

    Args:
        entries: Names with their types.
        only_count: Whether to print the number of names instead.
        show_types: Whether to print the types after each name.
        as_json: Whether to print a JSON list of the names instead.
    """
    if as_json:
        console.out_json([name for name, _ in entries])
    elif only_count:
        console.out(str(len(entries)))
    elif show_types:
        console.out_lines(f"{name} [{', '.join(types)}]" for name, types in entries)
    else:
        console.out_lines(name for name, _ in entries)


def out_types(types: Sequence[str], *, as_json: bool) -> None:
    """Print the types of a topic, service or action, one per line or as JSON."""
    if as_json:
        console.out_json(list(types))
    else:
        console.out_lines(types)


def out_files(files: Iterable[object], *, as_json: bool) -> None:
    """Print the paths of written files, one per line or as JSON."""
    if as_json:
        console.out_json({"files": [str(file) for file in files]})
    else:
        console.out_lines(map(str, files))


def types_of(name: str, known: NamesAndTypes, *, kind: str) -> Sequence[str]:
    """Return the types of a topic, service or action; raise NotFoundError if the name is unknown.

    Args:
        name: Full name to look up.
        known: All names with their types.
        kind: Kind of the name, such as ``topic``, for the error message.

    Raises:
        NotFoundError: The name is unknown.
    """
    types = dict(known)
    if name not in types:
        raise NotFoundError(f"Unknown {kind} '{name}'", hint=did_you_mean(name, types))
    return types[name]


def names_of_type(type_name: str, known: NamesAndTypes, *, kind: str) -> NamesAndTypes:
    """Return the pairs (name, types) that have a type; none, with a note, for an invalid type.

    Args:
        type_name: ``package/kind/Name`` or ``package/Name``.
        known: All names with their types.
        kind: Kind of a type name without one: ``msg``, ``srv`` or ``action``.
    """
    from teleopctl.interfaces import normalize

    try:
        wanted = normalize(type_name, kind)
    except InvalidTypeNameError as error:
        console.note(f"{error.message}: nothing has it")
        return []
    return [(name, types) for name, types in known if wanted in types]
