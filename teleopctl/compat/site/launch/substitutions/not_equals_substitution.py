"""``launch.substitutions.not_equals_substitution``."""

from ..frontend.expose import expose_substitution
from .equals_substitution import EqualsSubstitution


@expose_substitution("not-equals")
class NotEqualsSubstitution(EqualsSubstitution):
    """Whether two values differ as truth values, numbers or texts."""

    name_in_texts = "not-equals"
