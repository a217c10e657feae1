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
    """Print names of the graph, one per line, or their number, or JSON.

    Args:
        entries: Each name with its types.
        only_count: Print how many there are instead.
        show_types: Print the types behind each name.
        as_json: Print a list of the names instead.
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
        name: A full name.
        known: Every name with its types.
        kind: What it is the name of, for the message.

    Raises:
        NotFoundError: Nothing has that name.
    """
    types = dict(known)
    if name not in types:
        raise NotFoundError(f"Unknown {kind} '{name}'", hint=did_you_mean(name, types))
    return types[name]


def names_of_type(type_name: str, known: NamesAndTypes, *, kind: str) -> NamesAndTypes:
    """Return the entries that have a type; none, with a note on stderr, for an invalid type.

    Args:
        type_name: ``package/kind/Name`` or ``package/Name``.
        known: Every name with its types.
        kind: The kind meant when the name has none: ``msg``, ``srv`` or ``action``.
    """
    from teleopctl.interfaces import normalize

    try:
        wanted = normalize(type_name, kind)
    except InvalidTypeNameError as error:
        console.note(f"{error.message}: nothing has it")
        return []
    return [(name, types) for name, types in known if wanted in types]
