"""Declarations of verbs, and names for completion, cached in files between runs.

``--help`` and Tab completion need a verb's declarations, but not its module, whose imports take up
to ten times as long as Python's own start. So declarations are cached in files in the user's cache
folder, like Python's bytecode, with the size and modification time of every source file. If a
source file has changed, or the cache file cannot be read, the verb is imported.
"""

from __future__ import annotations

import marshal
import os
import sys

from teleopctl.base.folders import cache_dir
from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.verb import (
    Argument,
    Declaration,
    Option,
    Verb,
    VerbGroup,
    VerbParameter,
    parameters,
)
from teleopctl.errors import TeleopctlError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from typing import Any

    # Path, modification time (ns) and size of a file.
    Source = tuple[str, int, int]

_FORMAT = 1
_LONGEST_PLACE = 150  # file names may have 255 bytes
_PLAIN = {"bool": bool, "float": float, "int": int, "str": str}
_OF_VERBS = ("help", "negative_numbers", "passes_on", "passes_everything_on", "examples")


class DeclaredVerb:
    """Help text and parameters of a verb, read from the cache or from its function.

    Attributes:
        verb: Declaration of the verb.
        parameters: Parameters of the verb's function, in order.
        more: Paragraphs of the function's docstring below the first line, without sections.
    """

    __slots__ = ("more", "parameters", "verb")

    def __init__(self, verb: Verb, parameters: list[VerbParameter], more: Sequence[str]) -> None:
        self.verb = verb
        self.parameters = parameters
        self.more = more


def nouns() -> dict[str, str]:
    """Return the help line of each first word (noun or verb), by name, plug-ins included."""
    remembered = _read("verbs")
    if remembered is not None:
        return dict(remembered)
    before = set(sys.modules)
    found = _found_nouns()
    _write("verbs", before, tuple(found.items()), is_ours=False)
    return found


def find_declaration(path: Sequence[str]) -> DeclaredVerb | VerbGroup | None:
    """Return the declaration of the noun or verb named by ``path``; None if there is none.

    Raises:
        BrokenPluginError: The verb is from a plug-in that cannot be loaded.
    """
    if not all(word.replace("_", "").replace("-", "").isalnum() for word in path):
        return None
    name = f"verb.{'.'.join(path)}"
    remembered = _read(name)
    if remembered is not None:
        return _from_plain(remembered)
    before = set(sys.modules)
    found = _load(path)
    if found is not None:
        from teleopctl import plugins

        is_ours = path[0] in plugins.VERBS.builtin
        try:
            _write(name, before, _to_plain(found), is_ours=is_ours)
        except ValueError:
            return found  # a plug-in's verb with a default that cannot be cached
    return found


def cached_names(
    key: tuple[str, ...], read: Callable[[], tuple[list[str], Iterable[str]]]
) -> list[str]:
    """Return the names that a function reads from files, cached until a file changes.

    Args:
        key: Texts on which the names depend, besides the files.
        read: Function that returns the names and the paths of the files that they are from.
    """
    # One file per first texts, such as a launch file's name; the last one of them is kept.
    safe = "".join(letter if letter.isalnum() else "-" for letter in ".".join(key[:3]))
    name = f"names.{safe[:_LONGEST_PLACE]}"
    remembered = _read(name)
    if remembered is not None and remembered[0] == key:
        return list(remembered[1])
    before = set(sys.modules)
    found, files = read()
    _write(name, before, (key, tuple(found)), is_ours=True, files=files)
    return found


def _load(path: Sequence[str]) -> DeclaredVerb | VerbGroup | None:
    from teleopctl import plugins

    noun, *rest = path
    if plugins.find(plugins.VERBS, noun) is None:
        return None
    verb: Verb | VerbGroup | None = plugins.load(plugins.VERBS, noun)
    if rest:
        verb = verb.verbs.get(rest[0]) if isinstance(verb, VerbGroup) else None
    if verb is None or isinstance(verb, VerbGroup):
        return verb
    function = verb.load()
    # Without sections such as Args, which are for readers of the source: options have help texts.
    _, _, more = (function.__doc__ or "").partition("\n\n")
    paragraphs = more.partition("Args:")[0].partition("Raises:")[0].split("\n\n")
    # One line per paragraph, to be wrapped at the width of the terminal.
    texts = [" ".join(paragraph.split()) for paragraph in paragraphs]
    return DeclaredVerb(verb, parameters(function), [text for text in texts if text])


def _found_nouns() -> dict[str, str]:
    from teleopctl import plugins

    found = dict(plugins.VERBS.summaries)
    for name, plugin in plugins.available(plugins.VERBS).items():
        if plugin.distribution:
            try:
                summary = plugins.load(plugins.VERBS, name).help
            except TeleopctlError:
                summary = "Cannot be loaded."
            found[name] = f"{summary} (from {plugin.distribution})"
    return found


def _files(before: set[str], is_ours: bool) -> Iterable[str]:
    """Yield the files that a declaration depends on: loaded modules, and folders of `sys.path`.

    Args:
        before: Names of the modules that were loaded before the declaration.
        is_ours: Whether the verb is one of teleopctl, which depends on its modules only.
    """
    if not is_ours:
        yield from (place or "." for place in sys.path)  # changes with what is installed
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "teleopctl" or not (is_ours or name in before):
            file = getattr(module, "__file__", None)
            if file and not file.endswith((".so", ".pyd")):
                yield file


def _state(path: str) -> Source:
    try:
        found = os.stat(path)  # noqa: PTH116 -- pathlib takes longer to import than all of this
    except OSError:
        return (path, 0, 0)
    return (path, found.st_mtime_ns, found.st_size)


def _file(name: str) -> str:
    # One folder per environment: two environments used in turn would overwrite each other's files.
    place = f"{os.path.dirname(__file__)}-{sys.implementation.cache_tag}"  # noqa: PTH120
    place = "".join(letter if letter.isalnum() else "-" for letter in place[-_LONGEST_PLACE:])
    return f"{cache_dir()}/declared{place}/{name}"


# Any: plain values in tuples.
def _read(name: str) -> Any | None:
    try:
        with open(_file(name), "rb") as file:  # noqa: PTH123
            form, places, sources, value = marshal.loads(file.read())  # noqa: S302 -- our own
        if form != _FORMAT or places not in ([], sys.path):
            return None
        if any(_state(source[0]) != source for source in sources):
            return None
    except (OSError, ValueError, EOFError, TypeError, LookupError):
        return None
    return value


# Any: plain values in tuples.
def _write(
    name: str, before: set[str], value: Any, *, is_ours: bool, files: Iterable[str] = ()
) -> None:
    """Write a cache file; if that fails, the next run imports the verb again.

    Args:
        name: Name of the cache file.
        before: See `_files`.
        value: Value to cache.
        is_ours: See `_files`.
        files: Further files that the value depends on.

    Raises:
        ValueError: The value holds an object that cannot be marshalled.
    """
    path = _file(name)
    temporary = f"{path}.{os.getpid()}"
    sources = tuple(map(_state, dict.fromkeys([*files, *_files(before, is_ours)])))
    content = marshal.dumps((_FORMAT, [] if is_ours else sys.path, sources, value))
    try:
        os.makedirs(os.path.dirname(path), mode=0o700, exist_ok=True)  # noqa: PTH103, PTH120
        with open(temporary, "wb") as file:  # noqa: PTH123
            file.write(content)
        os.replace(temporary, path)  # noqa: PTH105
    except OSError:
        return


def _slots(declaration: Declaration) -> Sequence[str]:
    return (*Declaration.__slots__, *type(declaration).__slots__)


# Any: plain values in tuples.
def _to_plain(found: DeclaredVerb | VerbGroup) -> Any:
    if isinstance(found, VerbGroup):
        verbs = tuple((name, verb.target, verb.help) for name, verb in found.verbs.items())
        return ("group", found.help, found.alone, verbs)
    verb = tuple(getattr(found.verb, name) for name in _OF_VERBS)
    declared = tuple(
        (
            each.name,
            isinstance(each.declaration, Option),
            tuple(getattr(each.declaration, name) for name in _slots(each.declaration)),
            each.type.__name__,
            each.many,
            each.optional,
            each.default,
        )
        for each in found.parameters
    )
    if not all(each.type in _PLAIN.values() for each in found.parameters):
        raise ValueError("a type that is more than a plain one")
    return ("verb", found.verb.target, verb, declared, tuple(found.more))


# Any: value returned by `_to_plain`.
def _from_plain(plain: Any) -> DeclaredVerb | VerbGroup:
    if plain[0] == "group":
        _, text, alone, verbs = plain
        return VerbGroup(
            text, {name: Verb(target, line) for name, target, line in verbs}, alone=alone
        )
    _, target, values, declared, more = plain
    verb = Verb(target, **dict(zip(_OF_VERBS, values, strict=True)))
    found = []
    for name, is_option, content, type_name, many, optional, default in declared:
        declaration = Declaration.__new__(Option if is_option else Argument)
        for slot, value in zip(_slots(declaration), content, strict=True):
            setattr(declaration, slot, value)
        found.append(
            VerbParameter(
                name,
                declaration,
                _PLAIN[type_name],
                many=many,
                optional=optional,
                default=default,
            )
        )
    return DeclaredVerb(verb, found, more)
