"""``launch.some_substitutions_type``."""

import collections.abc
from collections.abc import Iterable
from os import PathLike

from .substitution import Substitution

SomeSubstitutionsType = str | PathLike[str] | Substitution | Iterable[str | Substitution]
SomeSubstitutionsType_types_tuple = (str, PathLike, Substitution, collections.abc.Iterable)
