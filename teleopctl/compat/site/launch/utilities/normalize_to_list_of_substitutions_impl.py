"""``launch.utilities.normalize_to_list_of_substitutions_impl``."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ..substitution import Substitution

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


def normalize_to_list_of_substitutions(subs: SomeSubstitutionsType) -> list[Substitution]:
    """Return a text, a path, a substitution, or a sequence of them as substitutions.

    Raises:
        TypeError: There is something else among them.
    """
    if isinstance(subs, str | Path | Substitution):
        return [_one(subs)]
    if not isinstance(subs, Iterable):
        raise _wrong(subs)
    return [_one(item) for item in subs]


# object: callers may pass anything, which is checked.
def _one(item: object) -> Substitution:
    from ..substitutions.text_substitution import TextSubstitution

    if isinstance(item, Substitution):
        return item
    if isinstance(item, str | Path):
        return TextSubstitution(text=str(item))
    raise _wrong(item)


def _wrong(item: object) -> TypeError:
    return TypeError(
        f"Failed to normalize given item of type '{type(item)}', when only "
        "'str' or 'launch.Substitution' were expected."
    )
