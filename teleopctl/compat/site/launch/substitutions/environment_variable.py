"""``launch.substitutions.environment_variable``."""

from ..frontend.expose import expose_substitution
from ..substitution import in_words
from ._with_default import WithDefault


@expose_substitution("env")
class EnvironmentVariable(WithDefault):
    """Value of an environment variable of the launched processes."""

    name_in_texts = "env"

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"EnvVar({in_words(self._name)})"
