"""``launch.substitutions.equals_substitution``."""

from __future__ import annotations

from typing import Any

from ..frontend.expose import expose_substitution
from ..substitution import Substitution
from ..utilities import normalize_to_list_of_substitutions
from ..utilities.type_utils import is_substitution
from ._of_two import OfTwo


# Any: whatever is to be compared.
def _normalized(value: Any) -> list[Substitution]:
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if value is None:
        return normalize_to_list_of_substitutions("")
    return normalize_to_list_of_substitutions(
        str(value).lower() if isinstance(value, bool) else str(value)
    )


@expose_substitution("equals")
class EqualsSubstitution(OfTwo):
    """Whether two values are equal as truth values, numbers or texts.

    Args:
        left: First value.
        right: The other one.
    """

    name_in_texts = "equals"

    # object: texts, numbers and truth values are all in use.
    def __init__(self, left: object, right: object) -> None:
        super().__init__(_normalized(left), _normalized(right))
